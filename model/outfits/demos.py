"""The outfits of the gallery: names, cuts and cloths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from .fabrics import Fabric, hex_colour
from .garnet_garments import PATTERNS
from .ornaments import Trimming
from .pattern import Pattern

SHIRT_NECK = (1.558, 1.597, 0.066, 2.0, 2.0)
CREW = (1.50, 1.545, 0.084, 2.2, 2.2)


@dataclass(frozen=True)
class Demo:
    """A named outfit: pieces from the inside out with their fabrics, and vertices per square metre."""

    name: str
    description: str
    pieces: tuple[tuple[Pattern | Trimming, Fabric], ...]
    density: int = 2600
    benchmark: bool = False
    kinds: Mapping[str, str] = field(default_factory=dict)  # by piece, of those that GarNet drapes


def _fabric(weave: str, *codes: str, tile: float = 0.12, sheen: float = 0.2, roughness: float = 0.88) -> Fabric:
    return Fabric(weave, tuple(hex_colour(c) for c in codes), tile, roughness, sheen, len(weave) + 7)


def _chinos(**changes: float) -> Pattern:
    base = {"top": 1.05, "hem": 0.095, "waist": 0.013, "hip": 0.018, "thigh": 0.020, "leg_hem": 0.022, "rise": 0.018}
    return Pattern("trousers", "trousers", looseness=0.6, **(base | changes))


def _tee(**changes: float | tuple) -> Pattern:
    base = {
        "hem": 0.88,
        "chest": 0.018,
        "waist": 0.020,
        "hip": 0.026,
        "sleeve": 0.20,
        "sleeve_ease": 0.016,
        "cuff_ease": 0.020,
    }
    return Pattern("T-shirt", "tee", **({"neck": CREW, "looseness": 0.55} | base | changes))


def _shirt(**changes: float | tuple | None) -> Pattern:
    base = {
        "hem": 0.94,
        "chest": 0.016,
        "waist": 0.018,
        "hip": 0.02,
        "sleeve": 0.515,
        "sleeve_ease": 0.014,
        "cuff_ease": 0.007,
    }
    return Pattern(**({"name": "shirt", "kind": "shirt", "neck": SHIRT_NECK, "looseness": 0.5} | base | changes))


def _dress(**changes: float | tuple | int) -> Pattern:
    base = {"chest": 0.012, "waist": 0.010, "hip": 0.014, "looseness": 0.05, "strap": 0.035, "armhole": 0.012}
    return Pattern(**({"name": "dress", "kind": "dress"} | base | changes))


def _tee_and_chinos() -> Demo:
    return Demo(
        "Linen T-shirt and chinos",
        "A soft linen T-shirt worn loose over straight cotton chinos.",
        ((_chinos(), _fabric("plain", "#b59a72")), (_tee(), _fabric("linen", "#e9e4d8"))),
        kinds={"trousers": "jeans", "T-shirt": "tee"},
    )


def _oxford_and_jeans() -> Demo:
    shirt = _shirt(tucked=1.04)
    jeans = _chinos(top=1.04, thigh=0.012, leg_hem=0.016, hem=0.10)
    oxford = _fabric("linen", "#a9c3de")
    return Demo(
        "Oxford shirt and jeans",
        "A pale blue shirt with a turned-down collar, tucked into dark denim.",
        (
            (shirt, oxford),
            (jeans, _fabric("denim", "#24344f", "#8fa0b8", tile=0.05)),
            (Trimming("collar", (0.036, 0.032), 0), _fabric("linen", "#b9d0e8")),
        ),
    )


def _summer_dress() -> Demo:
    dress = _dress(hem=0.56, neck=(1.41, 1.49, 0.105, 2.6, 2.4), skirt_from=1.17, flare=0.24, folds=9, fold_depth=0.012)
    flowers = _fabric("floral", "#f3ead7", "#d9705f", "#e0a13e", "#6f9270", "#fff6e0", tile=0.30)
    belt = Trimming("belt", (1.175, 0.035))
    return Demo(
        "Summer dress",
        "A sleeveless flowered cotton dress with a flared skirt and a narrow belt.",
        ((dress, flowers), (belt, _fabric("plain", "#a8543f"))),
    )


def _dot_dress() -> Demo:
    dress = _dress(
        hem=0.60,
        neck=(1.515, 1.535, 0.12, 3.0, 3.0),
        sleeve=0.15,
        sleeve_ease=0.014,
        cuff_ease=0.018,
        skirt_from=1.16,
        flare=0.36,
        folds=11,
        fold_depth=0.014,
        fold_phase=1.0,
    )
    return Demo(
        "Polka-dot dress with a bow",
        "A boat-necked tea dress in navy dots, a red bow at the waist.",
        (
            (dress, _fabric("dots", "#22305a", "#f2eee4", tile=0.16)),
            (Trimming("belt", (1.165, 0.04)), _fabric("plain", "#b3303a")),
            (Trimming("bow", (0.0, 1.165, 0.095)), _fabric("plain", "#b3303a", sheen=0.4)),
        ),
    )


def _tank_and_skirt() -> Demo:
    tank = Pattern(
        "tank top",
        "tank",
        hem=0.98,
        skin=0.005,
        chest=0.009,
        waist=0.009,
        hip=0.009,
        looseness=0.1,
        tucked=1.13,
        neck=(1.43, 1.48, 0.105, 2.6, 2.4),
        strap=0.035,
    )
    skirt = Pattern(
        "flared skirt",
        "skirt",
        top=1.14,
        hem=0.50,
        waist=0.013,
        hip=0.02,
        looseness=0.1,
        skirt_from=1.11,
        flare=0.34,
        folds=10,
        fold_depth=0.018,
        fold_phase=0.6,
    )
    return Demo(
        "Tank top and flared skirt",
        "A white ribbed tank tucked into a swinging terracotta skirt.",
        ((tank, _fabric("knit", "#f1efe9", tile=0.08)), (skirt, _fabric("linen", "#bf6a4a"))),
    )


def _office() -> Demo:
    shirt = _shirt(tucked=1.06, chest=0.014, sleeve=0.52)
    trousers = _chinos(top=1.065, leg_hem=0.020, hem=0.09)
    white = _fabric("plain", "#eef0f3")
    return Demo(
        "Shirt and tie",
        "A white shirt with a burgundy tie and charcoal pinstripe trousers.",
        (
            (shirt, white),
            (trousers, _fabric("pinstripe", "#3a3d45", "#8d9099", tile=0.14)),
            (Trimming("tie", (1.548, 0.48)), _fabric("herringbone", "#6e2233", "#8c3a49", tile=0.10, sheen=0.5)),
            (Trimming("collar", (0.034, 0.036), 0), _fabric("plain", "#fbfcfd")),
        ),
        density=3000,
    )


def _three_layers() -> Demo:
    under = _tee(
        hem=0.94, chest=0.012, waist=0.012, hip=0.014, sleeve_ease=0.008, cuff_ease=0.008, tucked=1.05, looseness=0.2
    )
    jacket = Pattern(
        "jacket",
        "jacket",
        hem=0.86,
        skin=0.010,
        chest=0.034,
        waist=0.032,
        hip=0.038,
        looseness=0.4,
        opening=0.085,
        neck=(1.20, 1.552, 0.088, 1.1, 2.2),
        sleeve=0.50,
        sleeve_ease=0.024,
        cuff_ease=0.018,
    )
    tweed = _fabric("herringbone", "#5a5247", "#7a6f5f", tile=0.09)
    return Demo(
        "Blazer, T-shirt and trousers",
        "Three layers: a tweed blazer, open, over a T-shirt tucked into navy trousers.",
        (
            (under, _fabric("stripes", "#eceae4", "#3c4d6b", tile=0.14)),
            (_chinos(), _fabric("plain", "#2f3a4f")),
            (jacket, tweed),
            (Trimming("lapels", (0.055, 1.08), 2), _fabric("herringbone", "#463f37", "#625849", tile=0.09)),
        ),
    )


def _jumpsuit() -> Demo:
    suit = Pattern(
        "jumpsuit",
        "jumpsuit",
        hem=0.12,
        chest=0.016,
        waist=0.016,
        hip=0.022,
        looseness=0.35,
        sleeve=0.17,
        sleeve_ease=0.016,
        cuff_ease=0.022,
        neck=(1.36, 1.54, 0.09, 1.15, 2.2),
        thigh=0.045,
        leg_hem=0.085,
        rise=0.025,
    )
    return Demo(
        "Wide-leg jumpsuit",
        "An olive V-necked jumpsuit with short sleeves, wide legs and a tied belt.",
        ((suit, _fabric("linen", "#6b7050")), (Trimming("belt", (1.15, 0.04)), _fabric("plain", "#4b4f38"))),
    )


def _cardigan() -> Demo:
    dress = _dress(
        hem=0.42, neck=(1.42, 1.50, 0.10, 7.0, 5.0), skirt_from=0.95, flare=0.05, waist=0.014, name="slip dress"
    )
    cardigan = Pattern(
        "cardigan",
        "jacket",
        hem=0.98,
        skin=0.010,
        chest=0.026,
        waist=0.026,
        hip=0.034,
        looseness=0.4,
        opening=0.07,
        neck=(1.26, 1.55, 0.09, 1.2, 2.2),
        sleeve=0.49,
        sleeve_ease=0.018,
        cuff_ease=0.012,
    )
    return Demo(
        "Slip dress and cardigan",
        "A long plum slip dress under an open knitted cardigan.",
        (
            (dress, _fabric("plain", "#5d3350", sheen=0.45, roughness=0.7)),
            (cardigan, _fabric("knit", "#cdbfa9", tile=0.10, sheen=0.35)),
        ),
    )


def _weekend() -> Demo:
    shorts = _chinos(hem=0.60, thigh=0.026, leg_hem=0.032, hip=0.02)
    return Demo(
        "Striped T-shirt and shorts",
        "A Breton stripe over stone-coloured shorts.",
        (
            (shorts, _fabric("plain", "#9c9482")),
            (_tee(hem=0.93, sleeve=0.18), _fabric("stripes", "#f0ede4", "#2c3c63", tile=0.17)),
        ),
    )


def _flannel() -> Demo:
    shirt = _shirt(
        name="overshirt",
        hem=0.84,
        chest=0.034,
        waist=0.034,
        hip=0.036,
        opening=0.045,
        neck=(1.52, 1.56, 0.088, 1.3, 2.2),
        skin=0.010,
        sleeve_ease=0.022,
        cuff_ease=0.013,
        hem_dip=0.03,
    )
    under = _tee(hem=0.93, chest=0.013, waist=0.015, hip=0.022, sleeve_ease=0.009, cuff_ease=0.009, looseness=0.3)
    return Demo(
        "Flannel overshirt and jeans",
        "A checked flannel worn open over a grey T-shirt and faded jeans.",
        (
            (_chinos(thigh=0.014, leg_hem=0.02), _fabric("denim", "#41587c", "#b3c0d2", tile=0.05)),
            (under, _fabric("plain", "#8d9196")),
            (shirt, _fabric("plaid", "#8a2f2b", "#2b2a33", "#d8c9a6", tile=0.20, sheen=0.35)),
        ),
    )


def _pencil() -> Demo:
    blouse = _shirt(
        name="blouse", hem=0.98, neck=(1.46, 1.54, 0.088, 1.4, 2.2), tucked=1.12, sleeve=0.42, cuff_ease=0.012
    )
    skirt = Pattern(
        "pencil skirt", "skirt", top=1.13, hem=0.50, waist=0.013, hip=0.014, looseness=0.0, skirt_from=0.92, flare=-0.03
    )
    return Demo(
        "Blouse and pencil skirt",
        "A sage blouse tucked into a high-waisted houndstooth-grey skirt.",
        (
            (blouse, _fabric("plain", "#b9c6b1", sheen=0.35)),
            (skirt, _fabric("herringbone", "#4c4c52", "#6e6e75", tile=0.07)),
        ),
    )


def _ball_gown() -> Demo:
    gown = _dress(
        hem=0.10,
        neck=(1.40, 1.46, 0.108, 4.0, 3.0),
        skirt_from=1.15,
        flare=0.33,
        folds=12,
        fold_depth=0.024,
        fold_phase=0.3,
        name="evening gown",
    )
    return Demo(
        "Evening gown",
        "A floor-length emerald gown with deep folds; 14 000 vertices, for benchmarks.",
        ((gown, _fabric("plain", "#0f5a4a", sheen=0.6, roughness=0.6)),),
        density=5200,
        benchmark=True,
    )


def _sweater_and_jeans() -> Demo:
    return Demo(
        "Sweater and jeans",
        "A loose rust-coloured sweater over faded straight jeans.",
        (
            (replace(PATTERNS["jeans"], name="jeans"), _fabric("denim", "#3c5574", "#a9b9cc", tile=0.05)),
            (PATTERNS["sweater"], _fabric("herringbone", "#a9532f", "#b9653f", tile=0.03, sheen=0.35)),
        ),
        kinds={"jeans": "jeans", "sweater": "sweater"},
    )


def _tea_dress() -> Demo:
    return Demo(
        "Tea dress",
        "A knee-length dress with short sleeves and a softly flared skirt.",
        ((PATTERNS["dress"], _fabric("floral", "#2f4f5c", "#e7d9c3", "#c96f5a", "#7fa08b", "#f6efe2", tile=0.26)),),
        kinds={"dress": "dress"},
    )


DEMOS = (
    _tee_and_chinos,
    _oxford_and_jeans,
    _summer_dress,
    _three_layers,
    _tank_and_skirt,
    _office,
    _dot_dress,
    _jumpsuit,
    _flannel,
    _cardigan,
    _weekend,
    _pencil,
    _sweater_and_jeans,
    _tea_dress,
    _ball_gown,
)
