//! A device with a finger on it as a client of a JACK server, in a process of its own: what a program plays goes in, what its sensors give comes
//! back on the inputs of that program. For rehearsals over a sound system, with no device.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use jack::{AudioIn, AudioOut, Client, ClientOptions, Control, Frames, Port, PortFlags, PortId};
use piezotact::quantity::{SampleRate, Seconds};
use piezotact_bench::{DeviceError, Plant};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::error::AudioError;
use crate::error::wrong;
use crate::setup::{Measures, SoundSetup};

/// The readings of the force cell, per second.
const READINGS_HZ: f64 = 80.0;
/// Readings that can wait.
const READINGS: usize = 4_096;

/// The port of a plant to which programs play; programs know by it that a plant stands behind a server.
const PLAYED_TO_SIMULATION: &str = "played_to_simulation";

/// Whether a plant stands behind the JACK server; no where there is no server.
pub(crate) fn is_behind_the_server() -> bool {
    jack::set_logger(jack::LoggerType::None);
    let options = ClientOptions::NO_START_SERVER;
    let Ok((client, _status)) = Client::new("piezotact_asks", options) else {
        return false;
    };
    let pattern = format!(":{PLAYED_TO_SIMULATION}$");
    let ports = client.ports(Some(&pattern), None, PortFlags::IS_INPUT);
    !ports.is_empty()
}

/// How a plant stands between output and inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantSettings {
    /// Its name among the clients of the server.
    pub name: String,
    /// The recorded value per played value of the loopback.
    pub gain: f64,
    /// The potential of the inputs at full scale, V peak.
    pub input_v_per_full_scale: f64,
}

/// A reading of the force cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceReading {
    /// By the clock of the plant, ms.
    pub at_ms: u32,
    pub force_n: f64,
}

/// A plant that runs. Drop it to leave the server.
pub struct JackPlant {
    client: jack::AsyncClient<Appeared, Process>,
    name: String,
    /// The channel of the drive among the ports of the program, and those of its inputs in the order of own outputs; from 0.
    drive: usize,
    inputs: Vec<usize>,
    known: BTreeSet<String>,
    changed: Arc<AtomicBool>,
    frames: Arc<AtomicU64>,
    readings: Consumer<ForceReading>,
    rate: SampleRate,
}

impl std::fmt::Debug for JackPlant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("JackPlant")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// What one output gives.
enum Wire {
    /// What was played, times this.
    Loopback(f64),
    /// This channel of the plant, times this; none where the plant has no such sensor.
    Sensor(Option<usize>, f64),
}

struct Process {
    drive: Port<AudioIn>,
    outputs: Vec<(Port<AudioOut>, Wire)>,
    plant: Box<dyn Plant>,
    played: Vec<f64>,
    through: Vec<Vec<f64>>,
    /// The loopback on its way, as late as the answer of the finger.
    behind: VecDeque<f64>,
    force: Option<usize>,
    cell: Cell,
    frames: Arc<AtomicU64>,
}

/// The force cell: means of what comes between two readings.
struct Cell {
    readings: Producer<ForceReading>,
    rate_hz: f64,
    sum: f64,
    count: u64,
    given: u64,
    frames: u64,
}

impl Cell {
    fn take(&mut self, force_n: f64) {
        self.sum += force_n;
        self.count += 1;
        self.frames += 1;
        let s = self.frames as f64 / self.rate_hz;
        if s * READINGS_HZ < (self.given + 1) as f64 {
            return;
        }
        self.given += 1;
        // Nobody reads: the reading is left out, as by a cell that nobody listens to.
        let _full = self.readings.push(ForceReading {
            at_ms: (1e3 * s) as u32,
            force_n: self.sum / self.count as f64,
        });
        (self.sum, self.count) = (0.0, 0);
    }
}

impl jack::ProcessHandler for Process {
    fn process(&mut self, _client: &Client, scope: &jack::ProcessScope) -> Control {
        self.played.clear();
        let heard = self.drive.as_slice(scope).iter();
        self.played.extend(heard.map(|v| f64::from(*v)));
        self.through.iter_mut().for_each(Vec::clear);
        self.plant.process(&self.played, &mut self.through);
        self.behind.extend(&self.played);
        for (port, wire) in &mut self.outputs {
            let out = port.as_mut_slice(scope);
            match wire {
                Wire::Loopback(gain) => {
                    for (out, played) in out.iter_mut().zip(&self.behind) {
                        *out = (*gain * played).clamp(-1.0, 1.0) as f32;
                    }
                }
                Wire::Sensor(Some(channel), scale) => {
                    for (out, value) in out.iter_mut().zip(&self.through[*channel]) {
                        *out = (*scale * value).clamp(-1.0, 1.0) as f32;
                    }
                }
                Wire::Sensor(None, _) => out.fill(0.0),
            }
        }
        self.behind.drain(..self.played.len());
        if let Some(force) = self.force {
            for value in &self.through[force] {
                self.cell.take(*value);
            }
        }
        let frames = self.played.len() as u64;
        self.frames.fetch_add(frames, Ordering::AcqRel);
        Control::Continue
    }
}

/// Notes that ports came or went.
struct Appeared(Arc<AtomicBool>);

impl jack::NotificationHandler for Appeared {
    fn port_registration(&mut self, _client: &Client, _port: PortId, _is_there: bool) {
        self.0.store(true, Ordering::Release);
    }

    fn sample_rate(&mut self, _client: &Client, _rate: Frames) -> Control {
        Control::Continue
    }
}

impl JackPlant {
    /// Joins the server that `setup` names by its host, at its rate, with the plant that `make` makes.
    ///
    /// # Errors
    /// [`AudioError::Setup`] for a set-up of another host or rate; [`AudioError::HostUnavailable`] without a server; whatever `make` refuses.
    pub fn start(
        setup: &SoundSetup,
        settings: &PlantSettings,
        make: impl FnOnce(SampleRate) -> Result<Box<dyn Plant>, DeviceError>,
    ) -> Result<Self, AudioError> {
        if setup.host != "jack" {
            let found = format!("host = \"{}\"", setup.host);
            return Err(wrong("a set-up with host = \"jack\"", &found));
        }
        if !setup.simulated {
            let expected =
                "simulated = true in the set-up, so that no recording is taken for one of a person";
            return Err(wrong(expected, "none"));
        }
        jack::set_logger(jack::LoggerType::None);
        let unavailable = |error: jack::Error| AudioError::HostUnavailable {
            host: "jack".into(),
            why: error.to_string(),
        };
        let options = ClientOptions::NO_START_SERVER;
        let (client, _status) = Client::new(&settings.name, options).map_err(unavailable)?;
        let rate = setup.rate()?;
        let of_server = f64::from(client.sample_rate());
        if of_server != rate.hz() {
            let found = format!("{of_server} Hz at the server");
            return Err(wrong(&format!("a rate of {} Hz", rate.hz()), &found));
        }
        let plant = make(rate)?;
        let sensors: Vec<String> = plant.channels().into_iter().map(|(name, _)| name).collect();
        let sensor = |measures: Measures| sensors.iter().position(|name| name == measures.name());
        let drive = client
            .register_port(PLAYED_TO_SIMULATION, AudioIn::default())
            .map_err(unavailable)?;
        let (mut outputs, mut inputs) = (Vec::new(), Vec::new());
        for recorded in &setup.record {
            let per_unit = recorded.v_per_unit().unwrap_or(1.0) / settings.input_v_per_full_scale;
            let wire = match recorded.measures {
                Measures::Drive => Wire::Loopback(settings.gain),
                other => Wire::Sensor(sensor(other), per_unit),
            };
            let port = client.register_port(recorded.measures.name(), AudioOut::default());
            outputs.push((port.map_err(unavailable)?, wire));
            inputs.push(recorded.channel as usize - 1);
        }
        let (push, readings) = RingBuffer::new(READINGS);
        let (changed, frames) = (Arc::new(AtomicBool::new(true)), Arc::default());
        let process = Process {
            drive,
            outputs,
            played: Vec::new(),
            through: vec![Vec::new(); sensors.len()],
            behind: VecDeque::from(vec![0.0; rate.samples_in(plant.delay())]),
            force: sensor(Measures::Force),
            plant,
            cell: Cell {
                readings: push,
                rate_hz: rate.hz(),
                sum: 0.0,
                count: 0,
                given: 0,
                frames: 0,
            },
            frames: Arc::clone(&frames),
        };
        let name = client.name().to_owned();
        let client = client
            .activate_async(Appeared(Arc::clone(&changed)), process)
            .map_err(unavailable)?;
        Ok(Self {
            client,
            name,
            drive: setup.play.drive.first().map_or(0, |at| *at as usize - 1),
            inputs,
            known: BTreeSet::new(),
            changed,
            frames,
            readings,
            rate,
        })
    }

    /// How long it has run by the clock of the server.
    #[must_use]
    pub fn ran(&self) -> Seconds {
        let frames = self.frames.load(Ordering::Acquire);
        self.rate.duration_of(frames as usize)
    }

    /// The readings of the force cell since the last call.
    pub fn readings(&mut self) -> Vec<ForceReading> {
        std::iter::from_fn(|| self.readings.pop().ok()).collect()
    }

    /// Connects programs of this kind that have opened their streams since; their ports, where there are new ones. What the server connected by
    /// itself to their inputs is taken off.
    pub fn connect(&mut self) -> Vec<String> {
        if !self.changed.swap(false, Ordering::AcqRel) {
            return Vec::new();
        }
        let client = self.client.as_client();
        let of = |pattern: &str, flags: PortFlags| client.ports(Some(pattern), None, flags);
        let played = of("^cpal_client_[0-9]+_out:out_[0-9]+$", PortFlags::IS_OUTPUT);
        let recorded = of("^cpal_client_[0-9]+_in:in_[0-9]+$", PortFlags::IS_INPUT);
        let number = |port: &str| port.rsplit('_').next()?.parse::<usize>().ok();
        let mut found = Vec::new();
        for port in &played {
            if number(port) == Some(self.drive) && !self.known.contains(port) {
                let own = format!("{}:{PLAYED_TO_SIMULATION}", self.name);
                if client.connect_ports_by_name(port, &own).is_ok() {
                    found.push(port.clone());
                }
            }
        }
        let own = of(&format!("^{}:", self.name), PortFlags::IS_OUTPUT);
        for port in &recorded {
            let channel = number(port);
            let place = self.inputs.iter().position(|input| Some(*input) == channel);
            let Some(own) = place.and_then(|place| own.get(place)) else {
                continue;
            };
            for other in of("^system:capture_", PortFlags::IS_OUTPUT) {
                let _was_not = client.disconnect_ports_by_name(&other, port);
            }
            if !self.known.contains(port) && client.connect_ports_by_name(own, port).is_ok() {
                found.push(port.clone());
            }
        }
        let there = played.iter().chain(&recorded);
        let connected = found.iter().chain(&self.known);
        let connected: BTreeSet<String> = connected.cloned().collect();
        self.known = there
            .filter(|port| connected.contains(*port))
            .cloned()
            .collect();
        found
    }
}
