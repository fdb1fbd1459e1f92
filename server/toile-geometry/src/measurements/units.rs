//! What someone meant who measured in another unit.

use super::{Measurement, MeasurementError, MeasurementInfo};

/// Centimetres in a metre, a millimetre, an inch and a foot.
const CENTIMETRES: [f32; 4] = [100.0, 0.1, 2.54, 30.48];
/// Kilograms in a pound, a stone and a gram.
const KILOGRAMS: [f32; 3] = [0.453_592, 6.350_29, 0.001];

/// Refuses a value outside the range, with a hint when it lies inside in another unit.
///
/// # Errors
/// [`MeasurementError::Units`] and [`MeasurementError::OutOfRange`].
pub(super) fn check(name: Measurement, value: f32, info: &MeasurementInfo) -> Result<(), MeasurementError> {
    let (min, max) = (info.min, info.max);
    if (min..=max).contains(&value) {
        return Ok(());
    }
    let units: &[f32] = if name == Measurement::Weight { &KILOGRAMS } else { &CENTIMETRES };
    let meant = units.iter().map(|unit| value * unit).find(|meant| (min..=max).contains(meant));
    Err(match meant {
        Some(meant) => MeasurementError::Units { name, value, meant: (meant * 10.0).round() / 10.0 },
        None => MeasurementError::OutOfRange { name, value, min, max },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hint(name: Measurement, value: f32, min: f32, max: f32) -> String {
        let info = MeasurementInfo {
            name: name.to_string(),
            label: String::new(),
            unit: String::new(),
            min,
            max,
            default: min,
            description: String::new(),
        };
        check(name, value, &info).map_or_else(|e| e.to_string(), |()| "fine".to_owned())
    }

    #[test]
    fn metres_millimetres_inches_and_feet_get_a_hint() {
        let height = |value| hint(Measurement::Height, value, 145.0, 205.0);
        assert_eq!(height(168.0), "fine");
        assert_eq!(height(1.68), "height is 1.68 cm; did you mean 168 cm?");
        assert_eq!(height(1680.0), "height is 1680 cm; did you mean 168 cm?");
        assert_eq!(height(66.0), "height is 66 cm; did you mean 167.6 cm?");
        assert_eq!(height(5.5), "height is 5.5 cm; did you mean 167.6 cm?");
        assert_eq!(hint(Measurement::Weight, 154.0, 40.0, 140.0), "weight is 154 kg; did you mean 69.9 kg?");
    }

    #[test]
    fn nonsense_gets_the_range() {
        let expected = "height is 20 cm; it must be between 145 and 205 cm";
        assert_eq!(hint(Measurement::Height, 20.0, 145.0, 205.0), expected);
        assert!(hint(Measurement::Height, f32::NAN, 145.0, 205.0).contains("must be between"));
        assert!(hint(Measurement::Height, -168.0, 145.0, 205.0).contains("must be between"));
    }
}
