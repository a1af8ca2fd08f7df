//! Where a file departs from the published structure of HJIF.

use std::collections::BTreeMap;

use serde_json::Value;

use super::hjif::{
    Hjif, HjifBand, HjifBandType, HjifChannel, HjifEffect, HjifEffectType, HjifPerception,
};

/// The ways of perceiving that the standard names.
const MODALITIES: [&str; 17] = [
    "Other",
    "Pressure",
    "Acceleration",
    "Velocity",
    "Position",
    "Temperature",
    "Vibrotactile",
    "Water",
    "Wind",
    "Force",
    "Electrotactile",
    "Vibrotactile Texture",
    "Stiffness",
    "Friction",
    "Humidity",
    "User-defined Temporal",
    "User-defined Spatial",
];

const ACTUATORS: [&str; 5] = ["Unknown", "LRA", "VCA", "ERM", "Piezo"];
const AVATARS: [&str; 4] = ["Vibration", "Pressure", "Temperature", "Custom"];

/// The most ticks of a second in the main profile.
const MOST_TICKS: u32 = 48_000;

/// What a check found.
struct Found(Vec<String>);

impl Found {
    fn when(&mut self, departs: impl Into<Option<String>>) {
        self.0.extend(departs.into());
    }

    fn unless(&mut self, holds: bool, departs: impl FnOnce() -> String) {
        if !holds {
            self.0.push(departs());
        }
    }

    fn unknown(&mut self, place: &str, fields: &BTreeMap<String, Value>) {
        let names: Vec<String> = fields
            .keys()
            .take(4)
            .map(|name| format!("`{name}`"))
            .collect();
        self.when((!names.is_empty()).then(|| format!("{place} has {}", names.join(", "))));
    }
}

impl Hjif {
    /// Where this departs from the structure and the rules that ISO/IEC 23090-31:2025 publishes, each in a few words;
    /// nothing for a file that conforms.
    ///
    /// Source: MPEGGroup/HapticReferenceSoftware, `source/IOHaptics/src/IOJson.cpp`, its checks of version, profile, level,
    /// date, timescale, identities, limits, and of what each type of band and effect must have.
    #[must_use]
    pub fn departures(&self) -> Vec<String> {
        let mut found = Found(Vec::new());
        found.unless(is_version(&self.version), || {
            format!("the version is `{}`, not a year from 2023", self.version)
        });
        let parametric = self.profile == "Simple Parametric";
        found.unless(parametric || self.profile == "Main", || {
            format!(
                "the profile is `{}`, not `Main` or `Simple Parametric`",
                self.profile
            )
        });
        found.unless(matches!(self.level, 1 | 2), || {
            format!("the level is {}, not 1 or 2", self.level)
        });
        found.unless(is_date(&self.date), || {
            format!("the date is `{}`, not as ISO 8601 writes it", self.date)
        });
        match self.timescale {
            None => found.when("there is no timescale".to_owned()),
            Some(ticks) if parametric => found.unless(ticks == 1000, || {
                format!("the timescale of the parametric profile is {ticks}, not 1000")
            }),
            Some(ticks) => found.unless((1..=MOST_TICKS).contains(&ticks), || {
                format!("the timescale is {ticks}, not 1 to {MOST_TICKS}")
            }),
        }
        found.unknown("the file", &self.unknown);
        let avatars: Vec<i64> = self.avatars.iter().map(|avatar| avatar.id).collect();
        distinct(&mut found, "avatar", &avatars);
        for avatar in &self.avatars {
            found.unless(avatar.id != 0, || {
                "an avatar has the reserved number 0".into()
            });
            found.unless(AVATARS.contains(&avatar.kind.as_str()), || {
                format!("the type of an avatar is `{}`", avatar.kind)
            });
        }
        let ids: Vec<i64> = self.perceptions.iter().map(|p| p.id).collect();
        distinct(&mut found, "perception", &ids);
        for perception in &self.perceptions {
            self.check_perception(perception, &avatars, &mut found);
        }
        found.0
    }

    fn check_perception(&self, perception: &HjifPerception, avatars: &[i64], found: &mut Found) {
        let modality = perception.perception_modality.as_str();
        found.unless(MODALITIES.contains(&modality), || {
            format!("the perception modality is `{modality}`")
        });
        found.unless(
            perception.avatar_id == 0 || avatars.contains(&perception.avatar_id),
            || format!("there is no avatar {}", perception.avatar_id),
        );
        found.unknown("a perception", &perception.unknown);
        let devices: Vec<i64> = perception.reference_devices.iter().map(|d| d.id).collect();
        distinct(found, "reference device", &devices);
        for device in &perception.reference_devices {
            let known = device
                .kind
                .as_deref()
                .is_none_or(|kind| ACTUATORS.contains(&kind));
            found.unless(known, || {
                format!("the type of `{}` is no actuator's", device.name)
            });
            let rising = [
                device.minimum_frequency,
                device.resonance_frequency,
                device.maximum_frequency,
            ];
            let rising: Vec<f64> = rising.into_iter().flatten().collect();
            found.unless(rising.is_sorted(), || {
                format!(
                    "minimum, resonance and maximum frequency of `{}` do not rise",
                    device.name
                )
            });
        }
        let library: Vec<i64> = perception
            .effect_library
            .iter()
            .filter_map(|e| e.id)
            .collect();
        distinct(found, "library effect", &library);
        for effect in &perception.effect_library {
            found.unless(effect.id.is_some(), || {
                "an effect of the library has no number".into()
            });
            check_effect(effect, &library, found);
        }
        let channels: Vec<i64> = perception.channels.iter().map(|c| c.id).collect();
        distinct(found, "channel", &channels);
        let most = if self.level == 1 { 128 } else { 65_536 };
        found.unless(channels.len() <= most, || {
            format!(
                "{} channels, at most {most} in level {}",
                channels.len(),
                self.level
            )
        });
        for channel in &perception.channels {
            self.check_channel(channel, &devices, &library, found);
        }
    }

    fn check_channel(
        &self,
        channel: &HjifChannel,
        devices: &[i64],
        library: &[i64],
        found: &mut Found,
    ) {
        found.unless(channel.mixing_coefficient.is_some(), || {
            let drafts = channel
                .mixing_weight
                .map_or("", |_| " but `mixing_weight`, as drafts wrote it");
            format!("channel {} has no `mixing_coefficient`{drafts}", channel.id)
        });
        found.unless(
            channel.mixing_coefficient.is_none() || channel.mixing_weight.is_none(),
            || format!("channel {} has `mixing_weight`", channel.id),
        );
        let device = channel.reference_device_id;
        found.unless(device.is_none_or(|id| devices.contains(&id)), || {
            format!(
                "channel {} refers to a device that is not there",
                channel.id
            )
        });
        found.unknown("a channel", &channel.unknown);
        let most = if self.level == 1 { 7 } else { 65_536 };
        found.unless(channel.bands.len() <= most, || {
            format!(
                "{} bands in channel {}, at most {most} in level {}",
                channel.bands.len(),
                channel.id,
                self.level
            )
        });
        for band in &channel.bands {
            self.check_band(band, library, found);
        }
    }

    fn check_band(&self, band: &HjifBand, library: &[i64], found: &mut Found) {
        let wavelets = band.band_type == HjifBandType::WaveletWave;
        found.unless(!wavelets || self.profile == "Main", || {
            "a band of wavelets outside the main profile".into()
        });
        let whole = band
            .block_length
            .as_ref()
            .is_some_and(serde_json::Number::is_u64);
        found.unless(!wavelets || whole, || {
            "the `block_length` of a band of wavelets is no whole number".into()
        });
        found.unless(wavelets || band.block_length.is_none(), || {
            format!("a band of type {:?} has a `block_length`", band.band_type)
        });
        found.unless(
            band.band_type == HjifBandType::Curve || band.curve_type.is_none(),
            || format!("a band of type {:?} has a `curve_type`", band.band_type),
        );
        found.unless(
            band.lower_frequency_limit <= band.upper_frequency_limit,
            || "a band ends below where it begins".into(),
        );
        found.unknown("a band", &band.unknown);
        for effect in &band.effects {
            check_effect(effect, library, found);
        }
    }
}

fn check_effect(effect: &HjifEffect, library: &[i64], found: &mut Found) {
    match effect.effect_type {
        HjifEffectType::Basis => found.unless(
            effect.phase.is_some() && effect.base_signal.is_some() && effect.keyframes.is_some(),
            || "an effect lacks `phase`, `base_signal` or `keyframes`".into(),
        ),
        HjifEffectType::Reference => {
            found.unless(effect.id.is_some_and(|id| library.contains(&id)), || {
                "an effect refers to one that is not in the library".into()
            });
        }
        HjifEffectType::Composite => {}
    }
    if effect.effect_type != HjifEffectType::Composite {
        found.unknown("an effect", &effect.unknown);
    }
}

fn distinct(found: &mut Found, what: &str, ids: &[i64]) {
    let mut sorted = ids.to_vec();
    sorted.sort_unstable();
    let twice = sorted.windows(2).find(|pair| pair[0] == pair[1]);
    found.when(twice.map(|pair| format!("there are two of {what} {}", pair[0])));
}

/// A year from 2023, with an amendment from 1 where there is one.
fn is_version(text: &str) -> bool {
    let (year, amendment) = text.split_once('-').unwrap_or((text, "1"));
    let is_year = year.len() == 4 && year.bytes().all(|byte| byte.is_ascii_digit());
    is_year
        && year >= "2023"
        && amendment.len() == 1
        && matches!(amendment.as_bytes()[0], b'1'..=b'9')
}

/// A date that begins as ISO 8601 writes it: `2025`, `2025-01` or `2025-01-31`, and perhaps a time.
fn is_date(text: &str) -> bool {
    let text = text.strip_prefix(['+', '-']).unwrap_or(text);
    let digits = |range: std::ops::Range<usize>| {
        text.get(range)
            .is_some_and(|part| part.bytes().all(|byte| byte.is_ascii_digit()))
    };
    digits(0..4)
        && (text.len() == 4
            || (text.get(4..5) == Some("-")
                && digits(5..7)
                && (text.len() == 7 || (text.get(7..8) == Some("-") && digits(8..10)))))
}
