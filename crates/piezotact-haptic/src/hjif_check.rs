//! Where a file departs from the published structure of HJIF.

use std::collections::BTreeMap;

use serde_json::{Number, Value};

use super::hjif::{
    Hjif, HjifBand, HjifBandType, HjifChannel, HjifEffect, HjifEffectType, HjifPerception,
    HjifReferenceDevice,
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
    fn add(&mut self, departure: impl Into<Option<String>>) {
        self.0.extend(departure.into());
    }

    fn unknown(&mut self, place: &str, fields: &BTreeMap<String, Value>) {
        let names: Vec<String> = fields
            .keys()
            .take(4)
            .map(|name| format!("`{name}`"))
            .collect();
        self.add((!names.is_empty()).then(|| format!("{place} has {}", names.join(", "))));
    }

    fn distinct(&mut self, what: &str, ids: &[i64]) {
        let mut sorted = ids.to_vec();
        sorted.sort_unstable();
        let twice = sorted.windows(2).find(|pair| pair[0] == pair[1]);
        self.add(twice.map(|pair| format!("there are two of {what} {}", pair[0])));
    }

    /// At most `most` of `what` in this level.
    fn count(&mut self, what: &str, found: usize, most: usize, level: u32) {
        self.add(
            (found > most).then(|| format!("{found} {what}, at most {most} in level {level}")),
        );
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
        let (main, parametric) = (self.profile == "Main", self.profile == "Simple Parametric");
        if !is_version(&self.version) {
            found.add(format!(
                "the version is `{}`, not a year from 2023",
                self.version
            ));
        }
        if !main && !parametric {
            found.add(format!(
                "the profile is `{}`, not `Main` or `Simple Parametric`",
                self.profile
            ));
        }
        if !matches!(self.level, 1 | 2) {
            found.add(format!("the level is {}, not 1 or 2", self.level));
        }
        if !is_date(&self.date) {
            found.add(format!(
                "the date is `{}`, not in ISO 8601 format",
                self.date
            ));
        }
        match self.timescale {
            None => found.add("there is no timescale".to_owned()),
            Some(ticks) if parametric && ticks != 1000 => found.add(format!(
                "the timescale of the parametric profile is {ticks}, not 1000"
            )),
            Some(ticks) if ticks == 0 || ticks > MOST_TICKS => {
                found.add(format!("the timescale is {ticks}, not 1 to {MOST_TICKS}"));
            }
            Some(_) => {}
        }
        found.unknown("the file", &self.unknown);
        let avatars: Vec<i64> = self.avatars.iter().map(|avatar| avatar.id).collect();
        found.distinct("avatar", &avatars);
        for avatar in &self.avatars {
            if avatar.id == 0 {
                found.add("an avatar has the reserved number 0".to_owned());
            }
            if !AVATARS.contains(&avatar.kind.as_str()) {
                found.add(format!("the type of an avatar is `{}`", avatar.kind));
            }
        }
        let ids: Vec<i64> = self.perceptions.iter().map(|p| p.id).collect();
        found.distinct("perception", &ids);
        for perception in &self.perceptions {
            self.check_perception(perception, &avatars, &mut found);
        }
        found.0
    }

    fn check_perception(&self, perception: &HjifPerception, avatars: &[i64], found: &mut Found) {
        let modality = perception.perception_modality.as_str();
        if !MODALITIES.contains(&modality) {
            found.add(format!("the perception modality is `{modality}`"));
        }
        if perception.avatar_id != 0 && !avatars.contains(&perception.avatar_id) {
            found.add(format!("there is no avatar {}", perception.avatar_id));
        }
        found.unknown("a perception", &perception.unknown);
        let devices: Vec<i64> = perception.reference_devices.iter().map(|d| d.id).collect();
        found.distinct("reference device", &devices);
        for device in &perception.reference_devices {
            check_device(device, found);
        }
        let library = &perception.effect_library;
        let numbers: Vec<i64> = library.iter().filter_map(|effect| effect.id).collect();
        found.distinct("library effect", &numbers);
        if numbers.len() < library.len() {
            found.add("an effect of the library has no number".to_owned());
        }
        for effect in library {
            check_effect(effect, &numbers, found);
        }
        let channels: Vec<i64> = perception.channels.iter().map(|c| c.id).collect();
        found.distinct("channel", &channels);
        let most = if self.level == 1 { 128 } else { 65_536 };
        found.count("channels", channels.len(), most, self.level);
        for channel in &perception.channels {
            self.check_channel(channel, &devices, &numbers, found);
        }
    }

    fn check_channel(
        &self,
        channel: &HjifChannel,
        devices: &[i64],
        library: &[i64],
        found: &mut Found,
    ) {
        match (channel.mixing_coefficient, channel.mixing_weight) {
            (Some(_), None) => {}
            (Some(_), Some(_)) => found.add(format!("channel {} has `mixing_weight`", channel.id)),
            (None, Some(_)) => found.add(format!(
                "channel {} has no `mixing_coefficient` but `mixing_weight`, as drafts wrote it",
                channel.id
            )),
            (None, None) => {
                found.add(format!(
                    "channel {} has no `mixing_coefficient`",
                    channel.id
                ));
            }
        }
        if channel
            .reference_device_id
            .is_some_and(|id| !devices.contains(&id))
        {
            found.add(format!(
                "channel {} refers to a device that is not there",
                channel.id
            ));
        }
        found.unknown("a channel", &channel.unknown);
        let most = if self.level == 1 { 7 } else { 65_536 };
        found.count("bands in a channel", channel.bands.len(), most, self.level);
        for band in &channel.bands {
            self.check_band(band, library, found);
        }
    }

    fn check_band(&self, band: &HjifBand, library: &[i64], found: &mut Found) {
        if band.band_type == HjifBandType::WaveletWave {
            if self.profile != "Main" {
                found.add("a band of wavelets outside the main profile".to_owned());
            }
            if !band.block_length.as_ref().is_some_and(Number::is_u64) {
                found.add("the `block_length` of a band of wavelets is no whole number".to_owned());
            }
        } else if band.block_length.is_some() {
            found.add(format!(
                "a band of type {:?} has a `block_length`",
                band.band_type
            ));
        }
        if band.band_type != HjifBandType::Curve && band.curve_type.is_some() {
            found.add(format!(
                "a band of type {:?} has a `curve_type`",
                band.band_type
            ));
        }
        if band.lower_frequency_limit > band.upper_frequency_limit {
            found.add("a band ends below where it begins".to_owned());
        }
        found.unknown("a band", &band.unknown);
        for effect in &band.effects {
            check_effect(effect, library, found);
        }
    }
}

fn check_device(device: &HjifReferenceDevice, found: &mut Found) {
    if let Some(kind) = &device.kind
        && !ACTUATORS.contains(&kind.as_str())
    {
        found.add(format!(
            "the type of `{}` is not an actuator type",
            device.name
        ));
    }
    let rising = [
        device.minimum_frequency,
        device.resonance_frequency,
        device.maximum_frequency,
    ];
    if !rising.into_iter().flatten().is_sorted() {
        found.add(format!(
            "minimum, resonance and maximum frequency of `{}` do not rise",
            device.name
        ));
    }
}

fn check_effect(effect: &HjifEffect, library: &[i64], found: &mut Found) {
    match effect.effect_type {
        HjifEffectType::Basis => {
            if effect.phase.is_none() || effect.base_signal.is_none() || effect.keyframes.is_none()
            {
                found.add("an effect lacks `phase`, `base_signal` or `keyframes`".to_owned());
            }
        }
        HjifEffectType::Reference => {
            if !effect.id.is_some_and(|id| library.contains(&id)) {
                found.add("an effect refers to one that is not in the library".to_owned());
            }
        }
        // What it is made of stands beside the fields above.
        HjifEffectType::Composite => return,
    }
    found.unknown("an effect", &effect.unknown);
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
