//! The average transfer function of a panel of people who do not take part (*thesis* 5.2).

use crate::VolunteerError;
use std::collections::BTreeSet;

use piezotact::panel::{Cell, Entry, Filing, Panel, average_of_panel};
use piezotact::quantity::{Acceleration, Degrees, Drive, Newtons};
use piezotact::transfer::{BundleAverage, TransferFunction};
use piezotact_twin::Participant;

use crate::person::{ANGLE_DEG, LOAD_N, band};
use crate::{Laboratory, Simulation, characterised, resting};

/// The average over the people `members`, each measured once on the device.
pub(super) fn averaged(
    simulation: &Simulation<'_>,
    members: &BTreeSet<u64>,
) -> Result<TransferFunction<Drive, Acceleration>, VolunteerError> {
    let laboratory = Laboratory {
        parameters: simulation.parameters.clone(),
        seed: simulation.seed,
    };
    let cell = Cell {
        load_n: Newtons(LOAD_N),
        angle_deg: Degrees(ANGLE_DEG),
    };
    let mut entries = Vec::new();
    for number in members {
        let asked = resting("characterise", LOAD_N, ANGLE_DEG);
        let mut bench = laboratory.device(*number);
        let function = characterised(&mut bench, asked, simulation.excitation_s, laboratory.seed)?;
        let person = Participant::of(*number, laboratory.seed, &laboratory.parameters);
        let filing = Filing {
            participant: person.pseudonym(),
            cell,
            placement: 1,
            repeat: 1,
        };
        entries.push(Entry { filing, function });
    }
    let panel = Panel::new(entries)?;
    let average = average_of_panel(&panel, cell, BundleAverage::LogMagnitude, band()?);
    Ok(average?.function)
}
