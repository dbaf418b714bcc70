//! Radiance of three channels as text.

use std::str::FromStr;

use glam::Vec3;

/// Maximum radiance of a channel (W m^-2 sr^-1).
const LARGEST: f32 = 1e30;

/// Radiance of each channel (W m^-2 sr^-1), from 0 to 1e30; as text `R,G,B`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radiance(pub Vec3);

impl Radiance {
    /// Radiance of three channels; `None` if one is out of range.
    pub fn new(channels: &[f32]) -> Option<Radiance> {
        let within = |channel: &f32| (0.0..=LARGEST).contains(channel);
        let channels: [f32; 3] = channels.try_into().ok()?;
        channels.iter().all(within).then(|| Radiance(channels.into()))
    }

    /// Whether a text is a list of numbers, and so is not a file name.
    pub(super) fn is_meant(text: &str) -> bool {
        text.split(',').all(|part| part.trim().parse::<f32>().is_ok())
    }
}

impl FromStr for Radiance {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Radiance, &'static str> {
        let channels: Option<Vec<f32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
        let radiance = channels.and_then(|channels| Radiance::new(&channels));
        radiance.ok_or("give three numbers from 0 to 1e30, such as 0.2,0.3,0.5")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radiance_is_parsed_from_three_numbers_in_range() {
        assert_eq!("0.5, 0,1e30".parse(), Ok(Radiance(Vec3::new(0.5, 0.0, 1e30))));
        for wrong in ["", "1", "1,2", "1,2,3,4", "1,2,x", "-1,0,0", "1e31,0,0", "nan,0,0", "sky.hdr"] {
            assert!(wrong.parse::<Radiance>().unwrap_err().contains("three numbers"), "{wrong}");
        }
        assert!(Radiance::is_meant("1,2") && Radiance::is_meant("nan,0,0") && !Radiance::is_meant("1,2.hdr"));
    }
}
