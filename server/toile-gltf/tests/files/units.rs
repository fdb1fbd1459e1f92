#![allow(clippy::unwrap_used)]

use glam::Vec3;
use serde_json::json;
use toile_gltf::{Format, Hints, Units, Up, read};

use crate::support::square_with;

/// The square of the chest, in other units and with another axis up.
fn scaled(factor: f32, up: Up) -> Vec<u8> {
    square_with(|json| {
        json["nodes"][0]["scale"] = json!([factor, factor, factor]);
        if up == Up::Z {
            // A quarter turn about x: y becomes z.
            json["nodes"][0]["rotation"] = json!([0.5_f32.sqrt(), 0, 0, 0.5_f32.sqrt()]);
        }
    })
}

#[test]
fn units_and_up_axis_are_found_from_where_the_outfit_lies() {
    for (unit, symbol) in [(Units::Metres, "m"), (Units::Centimetres, "cm"), (Units::Millimetres, "mm")] {
        for up in [Up::Y, Up::Z] {
            let bytes = scaled(1.0 / unit.in_metres(), up);
            let source = read(&bytes, Format::Glb, &Hints::default(), None).unwrap();
            assert_eq!((source.report.units.as_str(), source.report.up_axis.as_str()), (symbol, up.symbol()));
            assert!(source.meshes[0].positions[0].distance(Vec3::new(-0.1, 1.2, 0.2)) < 1e-4);
        }
    }
}

#[test]
fn what_was_assumed_is_said() {
    let source = read(&scaled(100.0, Up::Y), Format::Glb, &Hints::default(), None).unwrap();
    assert_eq!(source.report.scale_applied, 0.01);
    assert!(source.report.notes[0].contains("centimetres"), "{:?}", source.report.notes);
}

#[test]
fn stated_units_are_believed() {
    let hints = Hints { units: Some(Units::Centimetres), up: Some(Up::Y) };
    let source = read(&scaled(1.0, Up::Y), Format::Glb, &hints, None).unwrap();
    assert!(source.meshes[0].positions[0].distance(Vec3::new(-0.001, 0.012, 0.002)) < 1e-6);
}

#[test]
fn a_size_that_fits_in_no_unit_is_wrong() {
    for factor in [20_000.0, 1e-5] {
        let error = read(&scaled(factor, Up::Y), Format::Glb, &Hints::default(), None).unwrap_err();
        assert_eq!(error.code(), "wrong-units", "{error}");
    }
}

#[test]
fn a_place_that_fits_in_two_units_is_ambiguous_until_one_is_stated() {
    // The chest in inches is the knee in centimetres.
    let bytes = scaled(1.0 / 0.0254, Up::Y);
    let error = read(&bytes, Format::Glb, &Hints::default(), None).unwrap_err();
    assert_eq!(error.code(), "wrong-units");
    assert!(error.to_string().contains("in centimetres with y up or in inches with y up"), "{error}");
    let hints = Hints { units: Some(Units::Inches), up: None };
    let source = read(&bytes, Format::Glb, &hints, None).unwrap();
    assert!(source.meshes[0].positions[0].distance(Vec3::new(-0.1, 1.2, 0.2)) < 1e-4);
}

#[test]
fn symbols_are_read_and_others_refused() {
    assert_eq!("mm".parse(), Ok(Units::Millimetres));
    assert_eq!("z".parse(), Ok(Up::Z));
    assert!("ft".parse::<Units>().unwrap_err().contains("ft"));
    assert!("x".parse::<Up>().is_err());
}
