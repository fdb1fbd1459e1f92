"""The baked body against Anny's goldens, the poses, the tapes and the solver. No torch."""

from __future__ import annotations

import json

import numpy as np
import pytest
from safetensors import safe_open

from body import quaternions as qt
from body.anny_body import AnnyBody, vertex_normals
from body.clearance import Clearance, sample_bodies
from body.humanoid import joint_rotations, posed_world, split
from body.measure_solver import solve
from body.measuring import Tape
from body.pose_sampling import sample_pose, sample_poses
from body.poses import OUT as POSES
from body.poses import build
from body.walk import FRAMES, STANCE, STEP, ankle, knee_bends
from garment.folds import pinched

GOLDEN = POSES.parent / "golden" / "body.safetensors"
PRESETS = {"a-pose", "t-pose", "standing", "contrapposto", "hands-on-hips", "arms-up", "sitting", "squat", "reach"}
PRESETS |= {"lunge", "walk-1", "walk-2", "walk-3", "walk-4"}


@pytest.fixture(scope="module")
def body() -> AnnyBody:
    return AnnyBody.load()


@pytest.fixture(scope="module")
def tape(body: AnnyBody) -> Tape:
    return Tape(body)


@pytest.fixture(scope="module")
def poses() -> dict:
    return json.loads(POSES.read_text())


@pytest.fixture(scope="module")
def golden() -> tuple[dict, dict]:
    with safe_open(GOLDEN, "numpy") as f:
        return {k: f.get_tensor(k) for k in f.keys()}, json.loads(f.metadata()["toile"])  # noqa: SIM118


def all_rotations(poses: dict) -> list[dict]:
    return [p["rotations"] for p in poses["poses"]] + [f["rotations"] for m in poses["motions"] for f in m["frames"]]


def test_the_body_has_the_shapes_that_the_documentation_states(body: AnnyBody) -> None:
    assert body.shape_basis.shape == (176, 13718, 3)
    assert body.triangles.shape == (27420, 3) and body.triangles.max() == 13717
    assert len(body.joint_names) == 104 and len(body.garment_joints) == 36
    assert len(body.local_changes) == 20 and all(n.startswith("measure-") for n in body.local_changes)


def test_skin_weights_sum_to_one(body: AnnyBody) -> None:
    np.testing.assert_allclose(body.dense_skin.sum(1), 1, atol=1e-6)
    np.testing.assert_allclose(body.garment_skin.sum(1), 1, atol=1e-6)


def test_parents_come_before_their_children(body: AnnyBody) -> None:
    assert all(p < j for j, p in enumerate(body.parents)) and (body.parents < 0).sum() == 1


def test_humanoid_joints_name_joints_that_exist_once(body: AnnyBody) -> None:
    driven = [j for joints in body.meta["humanoid"].values() for j in joints]
    assert len(set(driven)) == len(driven) and set(driven) <= set(body.joint_names)
    np.testing.assert_allclose(np.linalg.norm(list(body.meta["bone_axes"].values()), axis=1), 1, atol=1e-5)


def test_the_body_agrees_with_anny(body: AnnyBody, golden: tuple[dict, dict]) -> None:
    expected, meta = golden
    for k, case in enumerate(meta["cases"]):
        shaped = body.shape(case["phenotypes"], case["local_changes"])
        world = posed_world(body, shaped, case["rotations"])
        stride = meta["stride"]
        np.testing.assert_allclose(shaped.apose_vertices[::stride], expected["apose_vertices"][k], atol=1e-4)
        np.testing.assert_allclose(body.pose(shaped, world)[::stride], expected["posed_vertices"][k], atol=1e-4)
        np.testing.assert_allclose(shaped.joints, expected["joints"][k], atol=1e-4)
        transforms = body.garment_transforms(shaped, world)
        np.testing.assert_allclose(transforms, expected["garment_transforms"][k], atol=2e-4)


def test_measurements_agree_with_the_goldens(body: AnnyBody, tape: Tape, golden: tuple[dict, dict]) -> None:
    expected, meta = golden
    for case, values in zip(meta["cases"], expected["measurements"], strict=True):
        measured = tape.measure(body.coefficients(case["phenotypes"], case["local_changes"]))
        np.testing.assert_allclose(measured, values, rtol=1e-5)


def test_split_rotations_agree_with_the_goldens(body: AnnyBody, golden: tuple[dict, dict]) -> None:
    expected, meta = golden
    rotations = dict(zip(meta["split_names"], expected["split_quaternions"], strict=True))
    np.testing.assert_allclose(joint_rotations(body, rotations), expected["split_rotations"], atol=2e-6)


@pytest.mark.parametrize("name", ["spine", "neck", "leftUpperArm", "rightLowerArm", "leftUpperLeg"])
def test_a_pair_of_joints_turns_by_the_whole_rotation(body: AnnyBody, name: str) -> None:
    q = np.random.default_rng(3).normal(size=4)
    q /= np.linalg.norm(q)
    first, second = split(body, name, q)
    np.testing.assert_allclose(qt.to_matrix(first) @ qt.to_matrix(second), qt.to_matrix(q), atol=1e-12)


def test_a_pure_twist_is_halved_and_a_pure_swing_is_not(body: AnnyBody) -> None:
    axis = np.array(body.meta["bone_axes"]["leftUpperArm"])
    first, second = split(body, "leftUpperArm", qt.about(axis, 80))
    np.testing.assert_allclose(first, qt.about(axis, 40), atol=1e-6)
    np.testing.assert_allclose(second, qt.about(axis, 40), atol=1e-6)
    swing = qt.about(np.cross(axis, [0, 1, 0]), 70)
    first, second = split(body, "leftUpperArm", swing)
    np.testing.assert_allclose(first, swing, atol=1e-6)
    np.testing.assert_allclose(second, qt.IDENTITY, atol=1e-6)


def test_rotation_matrices_become_quaternions_and_back() -> None:
    for q in np.random.default_rng(0).normal(size=(50, 4)):
        m = qt.to_matrix(q / np.linalg.norm(q))
        np.testing.assert_allclose(qt.to_matrix(qt.from_matrix(m)), m, atol=1e-12)


def test_the_presets_are_there_and_turn_known_joints_by_unit_quaternions(body: AnnyBody, poses: dict) -> None:
    ids = [p["id"] for p in poses["poses"]]
    assert len(set(ids)) == len(ids) and set(ids) >= PRESETS
    for rotations in all_rotations(poses):
        assert set(rotations) <= set(body.meta["humanoid"])
        for q in rotations.values():
            assert abs(np.linalg.norm(q) - 1) < 1e-6


def test_the_poses_file_is_what_the_code_writes(poses: dict) -> None:
    written = json.loads(json.dumps(build()))
    assert [p["id"] for p in written["poses"]] == [p["id"] for p in poses["poses"]]
    for new, old in zip(all_rotations(written), all_rotations(poses), strict=True):
        assert set(new) == set(old)
        for name in new:
            np.testing.assert_allclose(new[name], old[name], atol=1e-5)


def test_posed_bodies_stand_on_the_floor(body: AnnyBody, poses: dict) -> None:
    shaped = body.shape({"height": 0.4, "weight": 0.8})
    for pose in poses["poses"]:
        world = posed_world(body, shaped, pose["rotations"])
        assert abs(body.pose(shaped, world)[:, 1].min()) < 1e-6


def test_presets_keep_arms_out_of_the_trunk_and_legs_apart(body: AnnyBody, poses: dict) -> None:
    for values in ({}, {"weight": 0.1, "gender": 1.0}, {"weight": 0.9, "gender": 0.8}):
        clearance = Clearance(body, body.shape(values))
        for pose in poses["poses"]:
            room = clearance.room(pose["rotations"])
            assert min(room.forearms) > 0.015, pose["id"]
            assert clearance.legs_clear(room), pose["id"]


def test_the_clearance_sees_a_hand_inside_the_belly(body: AnnyBody) -> None:
    clearance = sample_bodies()[0]
    swung_in = {"leftUpperArm": qt.about(qt.Z, -65)}
    assert clearance.room(swung_in).forearms[0] < 0
    assert clearance.tight_arms(clearance.room(swung_in)) == (True, False)
    crossed = {"leftUpperLeg": qt.about(qt.Z, -22), "rightUpperLeg": qt.about(qt.Z, 22)}
    assert not clearance.legs_clear(clearance.room(crossed))


def test_the_walk_closes_and_its_stance_foot_moves_at_one_speed(poses: dict) -> None:
    frames = poses["motions"][0]["frames"]
    assert len(frames) == FRAMES
    steps = [turn_between(frames[k - 1], frames[k]) for k in range(FRAMES)]
    assert steps[0] < 1.5 * np.median(steps)
    flat = [ankle(phase) for phase in np.linspace(0.1, 0.32, 12)]
    np.testing.assert_allclose(np.diff([z for _, z, _ in flat]), -STEP / STANCE * 0.02, atol=1e-6)
    np.testing.assert_allclose([y for y, _, _ in flat], flat[0][0], atol=3e-3)


def turn_between(a: dict, b: dict) -> float:
    """Largest angle in degrees that any joint turns by from one frame to another."""
    names = set(a["rotations"]) | set(b["rotations"])
    pairs = [[np.array(f["rotations"].get(n, qt.IDENTITY)) for f in (a, b)] for n in names]
    return max(np.degrees(2 * np.arccos(min(1.0, abs(p @ q)))) for p, q in pairs)


def test_the_walking_knee_bends_twice_a_cycle() -> None:
    bends = np.array(knee_bends())
    peaks = [k for k in range(FRAMES) if bends[k] > max(bends[k - 1], bends[(k + 1) % FRAMES], 15)]
    loading, swing = min(peaks), max(peaks)
    assert loading / FRAMES < 0.25 and 12 < bends[loading] < 28
    assert 0.6 < swing / FRAMES < 0.85 and 50 < bends[swing] < 70


def test_sampled_poses_are_the_seeds_own_and_leave_room_for_cloth() -> None:
    first, again, other = (sample_poses(6, seed) for seed in (4, 4, 5))
    assert all(np.array_equal(a[n], b[n]) for a, b in zip(first, again, strict=True) for n in a)
    assert any(not np.array_equal(a.get(n), b.get(n)) for a, b in zip(first, other, strict=True) for n in a)
    heavy = sample_bodies()[1]
    for pose in first:
        assert min(heavy.room(pose).forearms) >= 0.03


def test_sampled_poses_are_varied_unit_quaternions(body: AnnyBody) -> None:
    rng = np.random.default_rng(1)
    drawn = [sample_pose(rng) for _ in range(60)]
    for pose in drawn:
        assert set(pose) <= set(body.meta["humanoid"])
        np.testing.assert_allclose([np.linalg.norm(q) for q in pose.values()], 1, atol=1e-9)
    turned = [np.degrees(2 * np.arccos(min(1.0, abs(p["leftUpperArm"][3])))) for p in drawn]
    assert np.std(turned) > 15


def test_tapes_lie_on_the_surface_in_order(body: AnnyBody, tape: Tape) -> None:
    ranges = body.tape["measure_ranges"]
    assert (ranges[1:, 0] == ranges[:-1, 1]).all() and ranges[-1, 1] == len(tape.points)
    assert body.tape["measure_points"].max() < 13718
    assert ((body.tape["measure_t"] >= 0) & (body.tape["measure_t"] <= 1)).all()
    for entry, (start, end) in zip(tape.entries, ranges, strict=True):
        if entry["kind"] == "ring":
            around = np.linalg.norm(np.diff(tape.points[start:end], axis=0), axis=1)
            assert around.max() < 0.25 * around.sum(), entry["name"]


def test_the_reference_body_measures_its_defaults_within_the_plausible_range(body: AnnyBody, tape: Tape) -> None:
    for entry, value in zip(tape.entries, tape.measure(body.coefficients()), strict=True):
        assert abs(entry["default"] - value) <= 0.051
        assert entry["min"] < value < entry["max"]


def test_the_coarse_mesh_is_closed_and_weighs_as_the_whole(body: AnnyBody, tape: Tape) -> None:
    t = body.tape["volume_triangles"].astype(np.int64)
    sides = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    there, back = np.sort(sides @ [100_000, 1]), np.sort(sides @ [1, 100_000])
    assert (there == back).all()
    for values in ({}, {"weight": 1.0, "gender": 0.2}, {"weight": 0.0, "height": 0.3}):
        v = body.shape(values).rest_vertices
        a, b, c = (v[body.triangles[:, k]] for k in range(3))
        whole = np.einsum("ta,ta->", a, np.cross(b, c)) / 6 * 980
        assert tape.measure(body.coefficients(values))[1] == pytest.approx(whole, rel=0.01)


@pytest.mark.parametrize(
    ("phenotype", "measurement"), [("weight", "waist"), ("weight", "hip"), ("weight", "weight"), ("height", "inseam")]
)
def test_more_of_a_phenotype_measures_more(body: AnnyBody, tape: Tape, phenotype: str, measurement: str) -> None:
    row = tape.names.index(measurement)
    values = [tape.measure(body.coefficients({phenotype: x}))[row] for x in (0.1, 0.4, 0.6, 0.9)]
    assert (np.diff(values) > 0.3).all()


def test_each_local_change_moves_its_own_measurement(body: AnnyBody, tape: Tape) -> None:
    named = {
        "waist": "waist-circ",
        "hip": "hips-circ",
        "neck": "neck-circ",
        "thigh": "thigh-circ",
        "chest": "bust-circ",
    }
    start = tape.measure(body.coefficients())
    for measurement, change in named.items():
        moved = tape.measure(body.coefficients(local={f"measure-{change}-incr": 0.5})) - start
        assert moved[tape.names.index(measurement)] > 0.5


def test_the_derivatives_of_the_measurements_are_right(body: AnnyBody, tape: Tape) -> None:
    c = body.coefficients({"weight": 0.7, "gender": 0.8})
    _, jacobian = tape.with_jacobian(c)
    step = np.random.default_rng(2).normal(size=len(c)) * 1e-5
    numeric = (tape.measure(c + step) - tape.measure(c - step)) / 2
    np.testing.assert_allclose(jacobian @ step, numeric, rtol=1e-4, atol=1e-9)


def random_adult(rng: np.random.Generator, body: AnnyBody) -> tuple[dict, dict]:
    phenotypes = {p: rng.uniform(0.1, 0.9) for p in body.phenotypes if p != "age"} | {"height": rng.uniform(0.3, 0.6)}
    return phenotypes, {n: float(np.clip(rng.normal(0, 0.35), -1, 1)) for n in body.local_changes}


def test_the_solver_reaches_reachable_bodies(body: AnnyBody, tape: Tape) -> None:
    rng = np.random.default_rng(11)
    for _ in range(6):
        target = tape.measure(body.coefficients(*random_adult(rng, body)))
        solution = solve(body, tape, dict(zip(tape.names, target.tolist(), strict=True)))
        assert np.sqrt(np.mean(np.square(list(solution.residuals.values())))) < 0.5
        measured = tape.measure(body.coefficients(solution.phenotypes, solution.local_changes))
        np.testing.assert_allclose(measured, list(solution.achieved.values()))


def test_the_solver_stays_within_bounds_and_tells_what_it_missed(body: AnnyBody, tape: Tape) -> None:
    solution = solve(body, tape, {"height": 150.0, "waist": 135.0, "hip": 80.0}, {"gender": 1.0})
    assert all(0 <= v <= 1 for v in solution.phenotypes.values()) and solution.phenotypes["gender"] == 1.0
    assert all(-1 <= v <= 1 for v in solution.local_changes.values())
    assert max(abs(r) for r in solution.residuals.values()) > 5


def test_asking_for_nothing_gives_the_reference_body(body: AnnyBody, tape: Tape) -> None:
    solution = solve(body, tape, {})
    assert solution.residuals == {} and set(solution.phenotypes.values()) == {0.5}


def test_an_unknown_measurement_is_refused(body: AnnyBody, tape: Tape) -> None:
    with pytest.raises(ValueError, match="shoe"):
        solve(body, tape, {"shoe": 42.0})


def test_a_squat_pinches_the_body_and_an_upright_pose_hardly(body: AnnyBody, poses: dict) -> None:
    shaped, counts = body.shape(), {}
    for pose in (p for p in poses["poses"] if p["id"] in ("a-pose", "squat")):
        posed = body.pose(shaped, posed_world(body, shaped, pose["rotations"]))
        counts[pose["id"]] = int(pinched(posed, vertex_normals(posed, body.triangles)).sum())
    assert counts["squat"] > 50 > 10 * counts["a-pose"], counts
