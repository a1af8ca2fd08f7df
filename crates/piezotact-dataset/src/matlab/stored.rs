//! Frequency responses among the variables of a MATLAB file, and the coherence and spectra an analyser stored with them.

use num_complex::Complex;
use piezotact::statistics::median;
use piezotact::transfer::StoredIdentities;

use super::{MatNumbers, MatValue};

/// Names of a response, its coherence, its cross-spectrum with the drive, and auto-spectra; in small letters, without the number of
/// a channel.
const RESPONSES: [&str; 5] = ["h", "frf", "h1", "hf", "tf"];
const COHERENCES: [&str; 5] = ["hf_coh", "coherence", "coh", "gamma2", "cxy"];
const CROSS_SPECTRA: [&str; 6] = [
    "hf_cross_spec",
    "cross_spec",
    "cross_spectrum",
    "cpsd",
    "gxy",
    "sxy",
];
const AUTO_SPECTRA: [&str; 4] = ["magspec", "auto_spec", "psd", "auto_spectrum"];
const OF_THE_DRIVE: [&str; 2] = ["gxx", "sxx"];
const OF_THE_RESPONSE: [&str; 2] = ["gyy", "syy"];
/// The channel of the drive in numbered files.
const DRIVE_CHANNEL: usize = 1;

/// A frequency response of a file.
pub(super) struct Response {
    /// The name of its variable.
    pub(super) name: String,
    /// The number of the channel in its name.
    channel: Option<usize>,
    /// One value a line.
    pub(super) values: Vec<Complex<f64>>,
}

/// The last part of a variable's name in small letters, and the number of the channel that it ends with.
fn parts(name: &str) -> (String, Option<usize>) {
    let last = name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    let stem = last.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = last[stem.len()..].parse().ok();
    let without = ["_chan_", "_chan", "_ch_", "_ch", "_"]
        .iter()
        .find_map(|end| stem.strip_suffix(end));
    match (without, number) {
        (Some(stem), Some(number)) => (stem.to_owned(), Some(number)),
        _ => (last, None),
    }
}

fn complex_of(value: &MatValue) -> Option<Vec<Complex<f64>>> {
    match value {
        MatValue::Numbers(MatNumbers {
            real,
            imaginary: Some(imaginary),
            ..
        }) if value_is_vector(value) => {
            let pairs = real.iter().zip(imaginary);
            Some(pairs.map(|(re, im)| Complex::new(*re, *im)).collect())
        }
        _ => None,
    }
}

fn value_is_vector(value: &MatValue) -> bool {
    matches!(value, MatValue::Numbers(numbers) if numbers.is_vector())
}

/// The frequency responses among `variables`: those without a channel first, in the order of the names, then by channel.
pub(super) fn responses(variables: &[(String, &MatValue)]) -> Vec<Response> {
    let mut found: Vec<(usize, Response)> = variables
        .iter()
        .filter_map(|(name, value)| {
            let (stem, channel) = parts(name);
            let rank = RESPONSES.iter().position(|known| *known == stem)?;
            let values = complex_of(value)?;
            let name = name.clone();
            Some((
                rank,
                Response {
                    name,
                    channel,
                    values,
                },
            ))
        })
        .collect();
    found.sort_by_key(|(rank, response)| (response.channel, *rank));
    found.into_iter().map(|(_, response)| response).collect()
}

impl Response {
    /// The variable that is called one of `names`, of this response's channel.
    fn own<'a>(
        &self,
        variables: &[(String, &'a MatValue)],
        names: &[&str],
    ) -> Option<&'a MatValue> {
        of_channel(variables, names, self.channel)
    }

    /// The coherence stored for it.
    pub(super) fn coherence(&self, variables: &[(String, &MatValue)]) -> Option<Vec<f64>> {
        let found = self.own(variables, &COHERENCES)?.vector()?;
        Some(found.to_vec())
    }

    /// How it agrees with the spectra stored beside it, which are on the lines `frequency_hz`; `None` where they are not there.
    pub(super) fn identities(
        &self,
        variables: &[(String, &MatValue)],
        frequency_hz: &[f64],
    ) -> Option<StoredIdentities> {
        let cross = complex_of(self.own(variables, &CROSS_SPECTRA)?)?;
        let coherence = self.coherence(variables);
        let (drive, response) = self.auto_spectra(variables, &cross, coherence.as_deref())?;
        let resolution_hz = frequency_hz.get(1)? - frequency_hz.first()?;
        let stored = (self.values.as_slice(), coherence.as_deref());
        // Spectra of another length belong to something else.
        StoredIdentities::of(stored, (drive, response), &cross, resolution_hz)
            .ok()
            .flatten()
    }

    /// The auto-spectra of drive and response on the scale of the cross-spectrum: an analyser stores them as powers and as
    /// densities.
    fn auto_spectra<'a>(
        &self,
        variables: &[(String, &'a MatValue)],
        cross: &[Complex<f64>],
        coherence: Option<&[f64]>,
    ) -> Option<(&'a [f64], &'a [f64])> {
        let pair = |drive: Option<&'a MatValue>, response: Option<&'a MatValue>| {
            let (drive, response) = (drive?.vector()?, response?.vector()?);
            let fits = drive.len() == cross.len() && response.len() == cross.len();
            fits.then_some((drive, response))
        };
        let named = pair(
            of_channel(variables, &OF_THE_DRIVE, None),
            self.own(variables, &OF_THE_RESPONSE),
        );
        let numbered = AUTO_SPECTRA.iter().filter_map(|name| {
            pair(
                of_channel(variables, &[name], Some(DRIVE_CHANNEL)),
                self.own(variables, &[name]),
            )
        });
        // By how much the ratio of cross- and auto-spectrum is larger than the response, or how far their coherence is from the
        // stored one: the median over lines.
        let scale = |(drive, response): &(&[f64], &[f64])| {
            if let Some(stored) = coherence.filter(|stored| stored.len() == cross.len()) {
                let powers = drive.iter().zip(response.iter());
                let mut each: Vec<f64> = (cross.iter().zip(powers).zip(stored))
                    .map(|((cross, (x, y)), stored)| (cross.norm_sqr() / (x * y) - stored).abs())
                    .collect();
                return median(&mut each).unwrap_or(f64::INFINITY);
            }
            let lines = cross.iter().zip(drive.iter()).zip(&self.values);
            let mut each: Vec<f64> = lines
                .filter(|((_, power), value)| **power > 0.0 && value.norm_sqr() > 0.0)
                .map(|((cross, power), value)| (cross.norm() / power / value.norm()).ln().abs())
                .collect();
            median(&mut each).unwrap_or(f64::INFINITY)
        };
        named
            .into_iter()
            .chain(numbered)
            .min_by(|a, b| scale(a).total_cmp(&scale(b)))
    }
}

/// The variable that is called one of `names`, of this channel.
fn of_channel<'a>(
    variables: &[(String, &'a MatValue)],
    names: &[&str],
    channel: Option<usize>,
) -> Option<&'a MatValue> {
    names.iter().find_map(|wanted| {
        let found = variables.iter().find(|(name, _)| {
            let (stem, found) = parts(name);
            stem == *wanted && found == channel
        });
        found.map(|(_, value)| *value)
    })
}
