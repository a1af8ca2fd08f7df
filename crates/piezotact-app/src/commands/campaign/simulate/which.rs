//! Which judge the answers of a simulated study show.

use piezotact_people::campaign::session::Stage;
use piezotact_people::campaign::store::Purpose;
use piezotact_people::judge::{Answers, Bounds, Touch, Which, which_judge};
use piezotact_study::store::Pseudonym;

use super::super::study::Study;
use crate::failure::Outcome;

/// Which judge the answers of a simulated study show, as an analysis that does not know it finds; `None` where no virtual volunteer
/// answered, and a reason where it cannot be compared.
pub(crate) fn which_of(study: &Study) -> Outcome<Option<Result<Which, String>>> {
    let mut answers = Answers::default();
    let mut virtual_sessions = 0;
    for (entry, plan) in study.live()? {
        let state = study.state(&plan)?;
        let counts = entry.purpose == Purpose::Volunteer && state.stage() != Stage::New;
        if !counts || state.participant().judge.is_none() {
            continue;
        }
        virtual_sessions += 1;
        let participant = Pseudonym::new(&plan.participant)?;
        let Some(judged) = study.store.judged::<Answers>(&participant, &plan.session)? else {
            return Ok(Some(Err(format!(
                "what was felt in session {} of {participant} is not kept: it was interrupted",
                plan.session
            ))));
        };
        answers.choices.extend(judged.choices);
        answers.orders.extend(judged.orders);
    }
    // Pairs that are compared and ratings name no judge.
    if virtual_sessions == 0 || answers.is_empty() {
        return Ok(None);
    }
    let which = which_judge(&answers, &Touch::mean_person(), Bounds::of_campaigns());
    Ok(Some(which.map_err(|error| error.to_string())))
}
