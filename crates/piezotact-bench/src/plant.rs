//! A device with a finger on it as a stream: what stands between an output and the inputs of a sound device that is not there.

use piezotact::quantity::{SampleRate, Seconds, Unit};

/// A device with a finger on it: what leaves an output goes in, what reaches the inputs comes out, sample for sample.
///
/// A twin is one. It stands behind an output that plays in real time, so nothing it does may depend on a sample to come.
pub trait Plant: Send {
    /// The rate of drive and channels.
    fn rate(&self) -> SampleRate;
    /// The names and SI units of what its sensors give.
    fn channels(&self) -> Vec<(String, Unit)>;
    /// How much later than that of the device its answer comes: whoever compares the answer with the drive delays the drive by as much.
    fn delay(&self) -> Seconds {
        Seconds(0.0)
    }
    /// Takes the next samples of the drive (full scale = 1) and appends as many to each of `channels`, in their SI units.
    ///
    /// `channels` has one list for each of [`Self::channels`].
    fn process(&mut self, drive: &[f64], channels: &mut [Vec<f64>]);
}
