//! Descriptions of devices: those that come with the program, and files of one's own.

use std::path::Path;

use piezotact::device::{BUILT_IN, DeviceDescription};

use crate::error::ReadError;

/// The device that comes with the program under a name, such as `drv2667`, else the one that a TOML file describes.
///
/// # Errors
/// [`ReadError`] naming the file, what was expected and what was found.
pub fn read_device(name_or_file: &str) -> Result<DeviceDescription, ReadError> {
    if let Some(device) = DeviceDescription::built_in(name_or_file) {
        return Ok(device);
    }
    let path = Path::new(name_or_file);
    let text = crate::reads::read_to_string(path).map_err(|error| {
        if error.kind() == std::io::ErrorKind::NotFound {
            let known: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
            ReadError::content(
                path,
                format!(
                    "a device that comes with the program ({}) or a TOML file that describes one",
                    known.join(", ")
                ),
                "neither",
                "check the name and the path",
            )
        } else {
            ReadError::io(path, &error)
        }
    })?;
    DeviceDescription::from_toml(&text).map_err(ReadError::of(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_read_by_name_or_from_a_file() {
        for (name, text) in BUILT_IN {
            let built_in = read_device(name).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("own.toml");
            std::fs::write(&file, text).unwrap();
            assert_eq!(read_device(file.to_str().unwrap()).unwrap(), built_in);
            std::fs::write(&file, text.replace("= 80e-9", "= -1")).unwrap();
            let said = read_device(file.to_str().unwrap()).unwrap_err().to_string();
            assert!(
                said.contains("own.toml: expected an actuator of 1e-12 to 1 F, found -1"),
                "{said}"
            );
        }
        let said = read_device("no-such.toml").unwrap_err().to_string();
        assert!(said.contains("(drv2667, fixed)"), "{said}");
    }

    /// The example in the guide is a description, and the fixed amplifier that comes with the program.
    #[test]
    fn the_example_of_the_guide_is_read() {
        let guide = include_str!("../../../docs/guide/files.md");
        let example = guide
            .split("```toml")
            .skip(1)
            .filter_map(|rest| rest.split("```").next())
            .find(|text| text.contains("[[amplifier.gains]]"))
            .unwrap();
        let device = DeviceDescription::from_toml(example).unwrap();
        let gain = device.only_gain().unwrap();
        assert_eq!((gain.voltage_ratio(), gain.limit_v), (20.0, 100.0));
        assert_eq!(device.actuator().capacitance_f, Some(120e-9));
        assert_eq!(device.input().divider, 0.5);
    }
}
