//! Bodies of given measurements.

use std::collections::BTreeMap;

use toile_geometry::body::{BodyShape, REFERENCE_AGE};
use toile_geometry::measurements::{Measurement, MeasurementError, Solution, by_measurement, measure, solve};

use super::body;

fn named(values: &[(&str, f32)]) -> BTreeMap<String, f32> {
    values.iter().map(|&(name, value)| (name.to_owned(), value)).collect()
}

fn solved(requested: &[(&str, f32)], fixed: &[(&str, f32)]) -> Result<Solution, MeasurementError> {
    solve(body(), &by_measurement(&named(requested))?, &named(fixed))
}

/// Numbers in [-1, 1) from a linear congruential generator (Knuth's MMIX constants).
fn noise(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 40) as f32 / (1 << 23) as f32 - 1.0
}

#[test]
fn the_reference_measures_as_the_body_file_says() {
    let found = measure(body(), &body().shape(&BodyShape::default()));
    for ((name, found), info) in found.iter().zip(body().measurements()) {
        assert_eq!(name.name(), info.name);
        assert_eq!(name.unit(), info.unit);
        assert!((found - info.default).abs() <= 0.051, "{name} is {found}, not {}", info.default);
    }
}

#[test]
fn nothing_requested_gives_the_reference_body() {
    assert_eq!(solved(&[], &[]).unwrap().shape, BodyShape::default());
}

#[test]
fn the_measurements_of_a_random_adult_are_met() {
    let (mut state, mut solved_bodies) = (11, 0);
    for round in 0..6 {
        let mut shape = BodyShape::default();
        shape.phenotypes = shape.phenotypes.map(|middle| middle + 0.3 * noise(&mut state));
        shape.phenotypes[1] = REFERENCE_AGE;
        shape.phenotypes[4] = 0.4 + 0.15 * noise(&mut state);
        shape.local_changes = shape.local_changes.map(|_| 0.4 * noise(&mut state));
        let own = measure(body(), &body().shape(&shape));
        let in_range = body()
            .measurements()
            .iter()
            .zip(own.iter())
            .all(|(info, (_, v))| (info.min..=info.max).contains(&v));
        if !in_range {
            continue;
        }
        solved_bodies += 1;
        let found = solve(body(), &own.iter().collect(), &BTreeMap::new()).unwrap();
        for (name, residual) in found.residuals {
            assert!(residual.abs() < 0.1, "round {round}: {name} misses by {residual}");
        }
    }
    assert!(solved_bodies >= 3, "only {solved_bodies} of the random bodies were in range");
}

#[test]
fn a_solution_states_what_it_achieved_and_keeps_what_is_fixed() {
    let requested = [("height", 168.0), ("bust", 90.0), ("waist", 72.0), ("hip", 98.0), ("weight", 60.0)];
    let found = solved(&requested, &[("gender", 1.0), ("measure-neck-circ-incr", 0.25)]).unwrap();
    assert_eq!(found.shape.phenotypes[0], 1.0);
    assert_eq!(found.shape.values(body())["measure-neck-circ-incr"], 0.25);
    assert_eq!(found.achieved, measure(body(), &body().shape(&found.shape)));
    assert_eq!(found.residuals.len(), 5);
    let chest = found.achieved.get(Measurement::Chest);
    assert_eq!(found.residuals[&Measurement::Chest], chest - 90.0);
    assert!((chest - 90.0).abs() < 0.1);
}

#[test]
fn a_height_in_metres_is_refused_with_what_was_meant() {
    let error = solved(&[("height", 1.68)], &[]).unwrap_err();
    assert_eq!(error.to_string(), "height is 1.68 cm; did you mean 168 cm?");
    assert!(matches!(error, MeasurementError::Units { name: Measurement::Height, meant: 168.0, .. }));
}

#[test]
fn unknown_doubled_and_impossible_values_are_refused() {
    assert!(
        matches!(solved(&[("calf", 40.0)], &[]), Err(MeasurementError::Unknown { name }) if name == "calf")
    );
    let twice = solved(&[("bust", 90.0), ("chest", 91.0)], &[]);
    assert!(matches!(twice, Err(MeasurementError::Twice { name: Measurement::Chest })));
    assert!(matches!(solved(&[("height", 300.0)], &[]), Err(MeasurementError::OutOfRange { .. })));
    assert!(matches!(solved(&[("height", f32::NAN)], &[]), Err(MeasurementError::OutOfRange { .. })));
    assert!(matches!(solved(&[], &[("gender", 2.0)]), Err(MeasurementError::Phenotype(_))));
}

#[test]
fn measurements_that_no_body_has_together_are_named() {
    let error = solved(&[("height", 150.0), ("inseam", 98.0), ("neck", 35.0)], &[]).unwrap_err();
    let MeasurementError::Unreachable { misses } = &error else { panic!("{error}") };
    assert!(misses.iter().any(|miss| miss.name == Measurement::Inseam), "{error}");
    assert!(misses.iter().all(|miss| miss.name != Measurement::Neck), "{error}");
}

#[test]
fn bounds_in_the_way_do_not_stop_the_search_early() {
    // A slim waist at such a mass drives most parameters to their bounds.
    let found = solved(&[("waist", 60.0), ("weight", 120.0)], &[]).unwrap();
    assert!(found.residuals.values().all(|residual| residual.abs() < 0.6), "{:?}", found.residuals);
}
