//! `piezotact campaign join`: makes the folder of a further station of a study.

use std::path::PathBuf;

use clap::Args;
use piezotact_people::campaign::store::Store as _;
use piezotact_study::store::StudyCampaign;

use super::new::database_url;
use crate::failure::Outcome;
use crate::output::print;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The database of the study, such as `postgres://user@host:5432/database`; the password is that of PGPASSWORD or ~/.pgpass.
    #[arg(value_name = "URL")]
    url: String,
    /// The folder of this station, which is made.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let url = database_url(&args.url)?;
    let store = StudyCampaign::join(&args.folder, &url)?;
    let campaign = store.campaign()?;
    print(&format!(
        "{}: a station of the study with the protocol {} and the seed {}, which is kept in {}; sessions so far: {}",
        args.folder.display(),
        campaign.protocol.name,
        campaign.seed,
        url,
        store.sessions()?.len()
    ))
}
