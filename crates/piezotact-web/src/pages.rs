//! The pages as HTML. A step is drawn here as a whole; the script of a page only puts it in its place and sends what is pressed.

use maud::{DOCTYPE, Markup, html};
use piezotact::criterion::Outcome;
use piezotact_people::campaign::session::UNKNOWN;

use crate::access::{Role, second_mark};
use crate::study;
use crate::view::{
    Closed, ClosedStep, Form, Heading, Measured, Open, OpenStep, PlayedBy, Repeats, Text, View,
};
use crate::words::{Language, Word};

/// Whether an experimenter's page hides what is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    Blind,
    Open,
}

/// How many letters keys have for choices: 1 to 9, then a to z without those of other keys.
const KEYS: &str = "123456789abcdefghijklmoqrstuvwxyz";

/// A whole page.
pub(crate) fn page(language: Language, title: &str, meta: &Markup, body: &Markup) -> Markup {
    html! {
        (DOCTYPE)
        html lang=(language.tag()) {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                (meta)
                link rel="stylesheet" href="/assets/session.css";
            }
            body { (body) }
        }
    }
}

/// How one enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Door {
    Code,
    /// On a network the experimenter has a password.
    CodeOrPassword,
}

/// The page where a code or a password is entered.
pub(crate) fn enter(language: Language, door: Door, code: &str, refused: Option<Word>) -> Markup {
    let w = |word: Word| word.in_language(language);
    let body = html! {
        main.enter {
            h1 { "Piezotact" }
            @if let Some(refused) = refused { p.alert role="alert" { (w(refused)) } }
            p { (w(Word::EnterCode)) }
            form method="post" action="/enter" {
                label { (w(Word::Code)) " "
                    input name="code" value=(code) autocomplete="off" autocapitalize="none" spellcheck="false" required;
                }
                button.main type="submit" { (w(Word::Enter)) }
            }
            @if door == Door::CodeOrPassword && code.is_empty() {
                p { (w(Word::EnterPassword)) }
                form method="post" action="/enter" {
                    label { (w(Word::PasswordWord)) " "
                        input type="password" name="password" autocomplete="current-password" required;
                    }
                    button.main type="submit" { (w(Word::Enter)) }
                }
            }
        }
    };
    page(language, "Piezotact", &html! {}, &body)
}

/// The frame of a page that follows the session, with its first `step`.
pub(crate) fn frame(
    (role, cookie): (Role, &str),
    language: Language,
    (stream, is_live): (&str, bool),
    step: &Markup,
) -> Markup {
    let w = |word: Word| word.in_language(language);
    let title = match role {
        Role::Participant => w(Word::ParticipantWord),
        Role::Experimenter | Role::Viewer => w(Word::Experimenter),
    };
    let meta = html! {
        meta name="piezotact-mark" content=(second_mark(cookie));
        meta name="piezotact-stream" content=(stream);
        script src="/assets/session.js" defer {}
        @if is_live { script src="/assets/live.js" defer {} }
    };
    let class = match role {
        Role::Participant => "participant",
        Role::Experimenter | Role::Viewer => "experimenter",
    };
    let body = html! {
        div #alerts role="alert" aria-live="assertive" {
            p #not-connected hidden { (w(Word::NotConnected)) @if role == Role::Participant { " " (w(Word::SayToStop)) } }
            p #not-stored hidden { (w(Word::NotStored)) " " span {} }
            p #moved-on hidden { (w(Word::MovedOn)) }
            p #not-yours hidden { (w(Word::NotYours)) }
            p #refused hidden data-plain=(w(Word::NotTaken)) {}
        }
        p #sending role="status" hidden data-playing=(w(Word::AfterTexture)) data-sending=(w(Word::Sending)) data-stopping=(w(Word::Stopping)) {}
        div #page class=(class) { (step) }
        @if is_live {
            section #gauge hidden aria-label=(w(Word::ForceWord)) data-low=(w(Word::ForceLow)) data-high=(w(Word::ForceHigh)) data-good=(w(Word::ForceGood)) {
                p { (w(Word::ForceWord)) " " output #gauge-now {} " " b #gauge-word {} }
                meter #gauge-meter min="0" max="2" value="0" aria-label=(w(Word::ForceWord)) {}
                button #gauge-tone type="button" aria-pressed="false" { (w(Word::ForceTone)) }
            }
        }
    };
    page(language, title, &meta, &body)
}

/// A colon with its space.
fn colon(language: Language) -> &'static str {
    match language {
        Language::English | Language::Italian => ": ",
        // A space that does not break stands before it.
        Language::French => "\u{a0}: ",
    }
}

/// A button that asks for `what`, which is JSON.
fn ask(what: &str, text: &str, class: &str) -> Markup {
    html! { button type="button" class=(class) data-ask=(what) { (text) } }
}

/// A button that has to be pressed twice.
fn ask_twice(what: &str, text: &str, again: &str) -> Markup {
    html! { button.main type="button" data-ask=(what) data-twice=(again) { (text) } }
}

fn ask_twice_small(what: &str, text: &str, again: &str) -> Markup {
    html! { button type="button" data-ask=(what) data-twice=(again) { (text) } }
}

/// What an answer is made with: the choices, the places that they fill, and the buttons to take back and to send.
fn form(form: &Form, mark: &str, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let [least, most] = form.count;
    let distinct = match form.repeats {
        Repeats::Once => "once",
        Repeats::Any => "any",
    };
    html! {
        @if !form.felt.is_empty() {
            ul.felt {
                @for (i, felt) in form.felt.iter().enumerate() {
                    li {
                        (w(Word::Texture)) " " (i + 1) (colon(language)) (w(Word::Felt)) " " (felt) "× "
                        (ask(&format!(r#"{{"do":"play","element":{}}}"#, i + 1), w(Word::PlayAgain), "small"))
                    }
                }
            }
        }
        @if most == 0 {
            p.ask { (form.more.in_language(language)) }
            (ask(r#"{"do":"confirm"}"#, w(Word::DoneWord), "main"))
        } @else {
            div.draft data-draft=(mark) data-final[form.is_final] data-noted=(form.noted.join("\n")) data-least=(least) data-most=(most) data-choose=(distinct) {
                p.ask { (w(form.ask)) " " (form.more.in_language(language)) }
                @if !form.is_final {
                    // A place that is pressed is filled next: one of them is changed in one step.
                    ol.slots aria-live="polite" {
                        @for i in 0..most.min(60) { li { button type="button" data-slot=(i) { "–" } } }
                    }
                }
                @let are_numbers = form.ask == Word::ANumber;
                div.choices role="group" aria-label=(w(form.ask)) data-numbers[are_numbers] {
                    @if let Some([from, to]) = form.number {
                        input.number type="text" inputmode="numeric" autocomplete="off" pattern="[-−]?[0-9]+" data-from=(from) data-to=(to) data-number="" aria-label=(w(form.ask));
                    }
                    @for (i, (choice, shown)) in form.choices.iter().enumerate() {
                        @let key = key(i, &form.choices).filter(|_| !are_numbers);
                        @let shown = shown.in_language(language);
                        button.choice type="button" data-choice=(choice) data-label=(shown) data-key=[key.clone()] {
                            (shown)
                            @if let Some(key) = key { @if key != choice.to_lowercase() { kbd aria-hidden="true" { (key) } } }
                        }
                    }
                }
                div.ends {
                    button type="button" data-undo="" disabled hidden[form.is_final] { (w(Word::Undo)) }
                    @if form.may_not_know {
                        button type="button" data-ask=(format!(r#"{{"do":"answer","words":["{UNKNOWN}"]}}"#)) { (w(Word::DoNotKnow)) }
                    }
                    button.main type="button" data-send="" disabled hidden[form.is_final] { (w(Word::ThisIsIt)) }
                }
            }
        }
    }
}

/// The key of choice `i`: its own letter where all choices are letters, else 1, 2, 3 …
fn key(i: usize, choices: &[(String, Text)]) -> Option<String> {
    match choices.iter().all(|(one, _)| one.chars().count() == 1) {
        true => choices.get(i).map(|(one, _)| one.to_lowercase()),
        false => KEYS.chars().nth(i).map(String::from),
    }
}

/// The participant's step, on one of so many open `pages`. It is made from what the participant may see, and from nothing else.
pub(crate) fn participant(open: &Open, language: Language, pages: usize) -> Markup {
    let language = of_participant(open, language);
    let w = |word: Word| word.in_language(language);
    let [done, all] = open.progress;
    html! {
        main lang=(language.tag()) data-mark=(open.mark) {
            h1.quiet { (w(Word::Progress)) (colon(language)) (done) " " (w(Word::Of)) " " (all) }
            progress value=(done) max=(all.max(1)) aria-label=(w(Word::Progress)) {}
            @if pages > 1 { p.alert role="alert" { (w(Word::OpenTwice)) } }
            @if let Some(right) = open.feedback.as_ref().filter(|_| !matches!(open.step, OpenStep::Playing(_))) {
                p.notice role="status" { (w(Word::RightAnswer)) " " b { (right.in_language(language)) } }
            }
            @match &open.step {
                OpenStep::Wait if open.instruction.is_some() && !open.begins => {
                    (instruction(open, language))
                    p.big { (w(Word::Wait)) }
                },
                OpenStep::Wait if open.begins => { p.big { (w(Word::NextBegins)) } },
                OpenStep::Wait | OpenStep::Consent(None) => { p.big { (w(Word::Wait)) } },
                OpenStep::Consent(Some(text)) => {
                    div.consent tabindex="0" { @for line in text.lines() { p { (line) } } }
                    p.big { (w(Word::AskYourConsent)) }
                    (ask_twice(r#"{"do":"consent"}"#, w(Word::IConsent), w(Word::PressAgain)))
                    p { (ask_twice_small(r#"{"do":"refuse_consent"}"#, w(Word::IDoNotConsent), w(Word::PressAgain))) }
                },
                OpenStep::Pause => { p.big { (w(Word::InPause)) } p { (w(Word::SayToStop)) } },
                OpenStep::Over => { p.big { (w(Word::Over)) } },
                OpenStep::Playing(which) => { (playing(*which, language)) },
                OpenStep::Answer(answer) => {
                    @if let Some(instruction) = &open.instruction { p.instruction { (instruction.in_language(language)) } }
                    (form(answer, &open.draft, language))
                    @if !answer.is_final { p.soft.keys { (w(Word::KeysHelp)) } }
                },
                OpenStep::Confirm { said, form: answer } => {
                    p.big { (w(Word::Noted)) " " b { (said.in_language(language)) } }
                    @if answer.repeats == Repeats::Once { p.soft { (answer.more.in_language(language)) } }
                    (ask(r#"{"do":"confirm"}"#, w(Word::Final), "main"))
                    details.change {
                        summary { (w(Word::Change)) }
                        (form(answer, &open.draft, language))
                    }
                },
            }
            @if open.can_pause {
                @let word = match open.step { OpenStep::Playing(_) => Word::StopTexture, _ => Word::NeedPause };
                div.always { (stop_button(r#"{"do":"pause"}"#, word, language)) }
            }
        }
    }
}

/// The language of the participant, or that of the page where none is stated.
pub(crate) fn of_participant(open: &Open, language: Language) -> Language {
    let stated = open.language.as_deref();
    stated.and_then(Language::of).unwrap_or(language)
}

/// Which texture of the trial is played: on the participant's page too, who answers for each of them.
fn playing([element, of]: [usize; 2], language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! { p.big data-playing="" { (w(Word::Playing)) " " b { (element) } " " (w(Word::Of)) " " (of) } }
}

/// A button that needs no turn: Escape presses it.
fn stop_button(what: &str, word: Word, language: Language) -> Markup {
    html! {
        button.stop[word == Word::StopTexture] type="button" data-ask=(what) data-stop="" {
            (word.in_language(language)) " " kbd { (Word::EscapeKey.in_language(language)) }
        }
    }
}

/// The experimenter's step; `pairing` is how the participant's device is let in, `pages` the number of experimenters' pages.
pub(crate) fn experimenter(
    view: &View,
    sight: Sight,
    language: Language,
    role: Role,
    (pairing, [pages, of_participant], draft): (&Pairing, [usize; 2], &[String]),
) -> Markup {
    let w = |word: Word| word.in_language(language);
    let View { open, closed } = view;
    html! {
        header {
            h1 { (closed.participant) " · " (closed.session) @if closed.is_rehearsal { " · " (w(Word::Rehearsal)) } }
            p.soft {
                (w(Word::EventsStored)) (colon(language)) b { (closed.events) }
                @if let Some(at_ms) = closed.last_ms { ", " (w(Word::LastAt)) " " time data-ms=(at_ms) {} }
                @if pages > 1 { " · " b { (pages) " " (w(Word::PagesOpen)) } }
            }
        }
        main data-mark=(open.mark) data-events=(closed.events) {
            section.step {
                @if let Some((word, text)) = &closed.notice { p.notice role="status" { (w(*word)) " " (text.in_language(language)) } }
                @if pairing.is_paired && of_participant == 0 { p.alert role="alert" { (w(Word::ParticipantAway)) } }
                @if let Some(heading) = &closed.heading { (title(heading, language)) }
                @if let OpenStep::Playing(which) = open.step {
                    (playing(which, language))
                    @if role == Role::Experimenter { (stop_button(r#"{"do":"silence"}"#, Word::StopTexture, language)) }
                } @else if role == Role::Viewer {
                    p.big { (sentence(closed, open, language)) }
                } @else {
                    (step(closed, open, sight, language))
                    @if !draft.is_empty() { p.soft.drafted { (w(Word::DraftOf)) " " b { (draft.join(", ")) } } }
                }
            }
            @if role == Role::Experimenter && !matches!(closed.step, ClosedStep::Over | ClosedStep::Stopped | ClosedStep::NoConsent | ClosedStep::Withdrawn) {
                section.aside { (aside(open, closed, language)) }
            }
            section.facts {
                (facts(closed, sight, role, language))
                @if role == Role::Experimenter { (paired(pairing, language)) }
                p {
                    a href="/study" { (w(Word::Sessions)) } " · "
                    @if matches!(closed.step, ClosedStep::Over | ClosedStep::Stopped) {
                        a href=(study::address(&closed.participant, &closed.session)) target="_blank" { (w(Word::SessionReport)) } " · "
                    }
                    (study::links(language))
                }
            }
        }
    }
}

fn title(heading: &Heading, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        h2 data-trial=(heading.number) {
            (w(Word::Trial)) " " (heading.number) " " (w(Word::Of)) " " (heading.of) " · " (heading.task.in_language(language))
            @if let Some(set) = &heading.set { " · " (w(Word::Set)) " " (set) }
            @if heading.is_training { " · " (w(Word::Training)) }
            @if heading.attempt > 1 { " · #" (heading.attempt) }
        }
    }
}

/// The step in one sentence, for a page that only looks.
fn sentence(closed: &Closed, open: &Open, language: Language) -> String {
    let w = |word: Word| word.in_language(language);
    match (&closed.step, &closed.answer) {
        _ if open.step == OpenStep::Pause => w(Word::InPause).to_owned(),
        (_, Some((_, Some(said)))) => {
            format!("{} {}", w(Word::Noted), said.in_language(language))
        }
        (ClosedStep::Consent(_), _) => w(Word::AskConsent).to_owned(),
        (ClosedStep::Check(item), _) => {
            format!("{} {}", w(Word::Check), item.in_language(language))
        }
        (ClosedStep::LayOut(samples), _) => format!("{} {}", w(Word::LayOut), samples.join(", ")),
        (ClosedStep::HandOver(sample), _) => format!("{} {sample}", w(Word::HandOver)),
        (ClosedStep::Play(count), _) => format!("{} {count}", w(Word::TexturesOnDevice)),
        (ClosedStep::PlayByHand(_), _) => w(Word::PlayByHand).to_owned(),
        (ClosedStep::Answer, Some((form, None))) => w(form.ask).to_owned(),
        (ClosedStep::Answer, None) => w(Word::Wait).to_owned(),
        (ClosedStep::End, _) => w(Word::AllDone).to_owned(),
        (ClosedStep::Over, _) => w(Word::Over).to_owned(),
        (ClosedStep::Stopped, _) => w(Word::StoppedEarly).to_owned(),
        (ClosedStep::NoConsent, _) => w(Word::EndedWithoutConsent).to_owned(),
        (ClosedStep::Withdrawn, _) => w(Word::Withdrawn).to_owned(),
    }
}

fn step(closed: &Closed, open: &Open, sight: Sight, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let present = r#"{"do":"present"}"#;
    let again = w(Word::PressAgain);
    html! {
        @if let OpenStep::Pause = open.step {
            p.big { (w(Word::InPause)) }
            (ask(r#"{"do":"go_on"}"#, w(Word::GoOn), "main"))
        } @else {
            @match &closed.step {
                ClosedStep::Consent(text) => {
                    div.consent tabindex="0" { @match text {
                        Some(text) => { @for line in text.lines() { p { (line) } } },
                        None => { p { (w(Word::ConsentInWords)) } },
                    } }
                    p.big { (w(Word::AskConsent)) }
                    (ask_twice(r#"{"do":"consent"}"#, w(Word::Yes), again))
                    (ask_twice_small(r#"{"do":"refuse_consent"}"#, w(Word::No), again))
                },
                ClosedStep::Check(item) => {
                    p.big { (w(Word::Check)) " " (item.in_language(language)) }
                    (ask(r#"{"do":"check"}"#, w(Word::ItIsSo), "main"))
                },
                ClosedStep::LayOut(samples) => {
                    (instruction(open, language))
                    p.big { (w(Word::LayOut)) }
                    ol.tray.places { @for sample in samples { li { (sample) (turned(closed, sample)) } } }
                    (ask(present, w(Word::LaidOut), "main"))
                    (instead(closed, language))
                },
                ClosedStep::HandOver(sample) => {
                    (instruction(open, language))
                    p.big { (w(Word::HandOver)) " " b.sample { (sample) } (turned(closed, sample)) }
                    (ask_twice(present, &format!("{}{}{sample}", w(Word::HandedOver), colon(language)), again))
                    (instead(closed, language))
                },
                ClosedStep::Play(count) => {
                    (instruction(open, language))
                    (own_order(closed, language))
                    p.big data-sounds="" { (w(Word::TexturesOnDevice)) " " (count) @if sight == Sight::Open { ": " (closed.presented.join(", ")) } }
                    @if open.begins { p { (w(Word::NextBegins)) } }
                    (ask(present, w(Word::PlayThem), "main"))
                },
                ClosedStep::PlayByHand(names) => {
                    (instruction(open, language))
                    (own_order(closed, language))
                    p.big { (w(Word::PlayByHand)) }
                    ol.tray { @for name in names { li { (name) } } }
                    (ask(present, w(Word::Played), "main"))
                    (instead(closed, language))
                },
                ClosedStep::Answer => { (answer(closed, open, sight, language)) },
                ClosedStep::End => {
                    p.big { (w(Word::AllDone)) }
                    (ask(r#"{"do":"end"}"#, w(Word::EndSession), "main"))
                },
                ClosedStep::Over => { p.big { (w(Word::Over)) } },
                ClosedStep::Stopped => { p.big { (w(Word::StoppedEarly)) } },
                ClosedStep::NoConsent => { p.big { (w(Word::EndedWithoutConsent)) } },
                ClosedStep::Withdrawn => { p.big { (w(Word::Withdrawn)) " " code { "piezotact campaign withdraw STUDY " (closed.participant) } } },
            }
        }
    }
}

/// What the participant is asked, to be read out in the participant's language where it is known.
fn instruction(open: &Open, language: Language) -> Markup {
    let stated = open.language.as_deref().and_then(Language::of);
    let language = stated.unwrap_or(language);
    html! { @if let Some(text) = &open.instruction { blockquote { (text.in_language(language)) } } }
}

/// How `sample` is turned; nothing where the protocol does not say it.
fn turned(closed: &Closed, sample: &str) -> Markup {
    let turned = closed.orientation.get(sample);
    html! { @if let Some(turned) = turned { " " span.soft { "(" (turned) ")" } } }
}

/// What is played, where it was asked for: names beside an answer could be told. By hand it is needed to play it again, and is folded away.
fn played(closed: &Closed, sight: Sight, language: Language) -> Markup {
    let names = html! { ol.tray { @for name in &closed.presented { li { (name) } } } };
    html! {
        @match (closed.played_by, sight) {
            (Some(PlayedBy::Hand), _) => { details { summary { (Word::ShowPlayed.in_language(language)) } (names) } },
            (Some(PlayedBy::Bench), Sight::Open) => { (names) },
            (Some(PlayedBy::Bench), Sight::Blind) | (None, _) => {},
        }
    }
}

fn answer(closed: &Closed, open: &Open, sight: Sight, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        (own_order(closed, language))
        (played(closed, sight, language))
        @match &closed.answer {
            Some((answer, None)) => { (form(answer, &open.draft, language)) },
            Some((answer, Some(said))) => {
                p.big { (w(Word::Noted)) " " b { (said.in_language(language)) } }
                (ask(r#"{"do":"confirm"}"#, w(Word::Final), "main"))
                details.change { summary { (w(Word::Change)) } (form(answer, &open.draft, language)) }
            },
            None => { p.big { (w(Word::Wait)) } },
        }
    }
}

fn own_order(closed: &Closed, language: Language) -> Markup {
    html! {
        @if !closed.own_order.is_empty() {
            p { (Word::OwnOrder.in_language(language)) }
            ol.tray.lettered { @for (letter, sample) in &closed.own_order { li { b { (letter) } " " (sample) (turned(closed, sample)) } } }
        }
    }
}

/// Other samples than planned were presented.
fn instead(closed: &Closed, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let wanted = closed.presented.len();
    html! {
        details {
            summary { (w(Word::AnotherOne)) }
            form.instead data-names="present_instead" {
                fieldset {
                    legend { (w(Word::WhichOnes)) }
                    @for i in 0..wanted {
                        select required aria-label=(format!("{} {}", w(Word::WhichOnes), i + 1)) {
                            // No sample is preselected.
                            option value="" { "–" }
                            @for sample in &closed.samples {
                                option value=(sample) { (sample) }
                            }
                        }
                    }
                }
                button type="submit" { (w(Word::AnotherOne)) }
            }
        }
    }
}

/// What can be done at any step.
fn aside(open: &Open, closed: &Closed, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let confirmed = &closed.answered;
    html! {
        @if !matches!(open.step, OpenStep::Pause) && closed.heading.is_some() {
            (ask(r#"{"do":"pause"}"#, w(Word::Pause), "small"))
        }
        form.note data-text="note" {
            label { (w(Word::Note)) " " input name="text" autocomplete="off" required; }
            button type="submit" { (w(Word::KeepNote)) }
        }
        @if !confirmed.is_empty() {
            details {
                summary { (w(Word::Correct)) }
                form.correct data-correct="" {
                    label { (w(Word::Trial)) " "
                        select name="trial" required {
                            // None is chosen: the newest changes while something is typed.
                            option value="" { "–" }
                            @for one in confirmed {
                                option value=(one.name) { (one.number) " · " (one.task) " · " (one.said) }
                            }
                        }
                    }
                    label { (w(Word::NewAnswer)) " " input name="words" autocomplete="off" required; }
                    label { (w(Word::Why)) " " input name="why" autocomplete="off" required; }
                    button type="submit" { (w(Word::KeepCorrection)) }
                }
            }
        }
        details {
            summary { (w(Word::Stop)) " · " (w(Word::Withdraw)) }
            form.stop data-why="stop" {
                label { (w(Word::Why)) " " input name="text" autocomplete="off"; }
                button type="submit" { (w(Word::Stop)) }
            }
            button.grave type="button" data-ask=(r#"{"do":"withdraw"}"#) data-twice=(w(Word::PressAgain)) { (w(Word::Withdraw)) }
        }
    }
}

fn facts(closed: &Closed, sight: Sight, role: Role, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        h2 { (w(Word::Progress)) }
        ul.tasks {
            @for (task, done, planned) in &closed.tasks {
                li { (task) (colon(language)) (done) " " (w(Word::Of)) " " (planned)
                    progress value=(done) max=((*planned).max(1)) aria-label=(task) {}
                }
            }
        }
        @if !closed.evidence.is_empty() {
            h2 { (w(Word::LastStimulus)) }
            ul.evidence { (measured(&closed.evidence, sight, language)) }
        }
        @if !closed.answered.is_empty() {
            details {
                summary { (w(Word::Answers)) " (" (closed.answered.len()) ")" }
                ul.answers {
                    @for one in &closed.answered {
                        li { (one.number) " · " (one.task) ": " (one.said) @if one.is_corrected { " *" } }
                    }
                }
            }
        }
        @if !closed.log.is_empty() {
            details {
                summary { (w(Word::Log)) }
                ul.log { @for (at_ms, what) in &closed.log { li { time data-ms=(at_ms) {} " " (what) } } }
            }
        }
        @if role == Role::Experimenter && closed.played_by != Some(PlayedBy::Hand) {
            p.soft {
                @match sight {
                    Sight::Blind => { (w(Word::Blind)) " " a href="/experimenter?sight=open" { (w(Word::ShowPlayed)) } },
                    Sight::Open => { a href="/experimenter" { (w(Word::HidePlayed)) } },
                }
            }
        }
    }
}

/// What was measured of the stimuli of a trial: a level, or which of them missed its target, could tell which ones they were.
fn measured(all: &[Measured], sight: Sight, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    let outcome = |of: &[Measured]| {
        let any = |outcome| of.iter().any(|one| one.reached == outcome);
        match () {
            () if any(Outcome::NotMet) => ("bad", w(Word::TargetNotMet)),
            () if any(Outcome::NotDecided) => ("", w(Word::TargetOpen)),
            () => ("", w(Word::TargetMet)),
        }
    };
    let together = outcome(all);
    html! {
        @if sight == Sight::Blind { li class=(together.0) { (together.1) } }
        @for one in all {
            @let own = outcome(std::slice::from_ref(one));
            @let force = one.force_n.map(|force| format!("{} {force:.2} N", w(Word::ForceWord)));
            @if sight == Sight::Open {
                li class=(own.0) {
                    (w(Word::Texture)) " " (one.element) (colon(language)) (own.1)
                    @if let Some(level) = one.level_db { ", " (w(Word::Level)) " " (decibels(level)) }
                    @if let Some(force) = force { ", " (force) }
                }
            } @else if let Some(force) = force {
                li { (w(Word::Texture)) " " (one.element) (colon(language)) (force) }
            }
        }
    }
}

/// A level with its sign; zero has none.
fn decibels(level_db: f64) -> String {
    match format!("{level_db:+.1}").as_str() {
        "+0.0" | "-0.0" => "0.0 dB".to_owned(),
        signed => format!("{signed} dB").replace('-', "−"),
    }
}

/// How the participant's device is let in.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pairing {
    /// Where the code is entered, with the code; none before one was made, or after it was used.
    pub(crate) address: Option<String>,
    /// Whether it is opened from another machine.
    pub(crate) from_network: bool,
    /// Whether a device is connected.
    pub(crate) is_paired: bool,
}

fn paired(pairing: &Pairing, language: Language) -> Markup {
    let w = |word: Word| word.in_language(language);
    html! {
        details open[pairing.address.is_some()] {
            summary { (w(Word::ParticipantPage)) }
            p { (w(match pairing.is_paired { true => Word::Paired, false => Word::NotPaired })) }
            @if let Some(address) = &pairing.address {
                p { (w(match pairing.from_network { true => Word::PairingFromNetwork, false => Word::PairingHelp })) }
                p { code { (address) } }
                @if pairing.from_network { (crate::qr::picture(address, w(Word::CodeAsPicture))) }
            }
            button type="button" data-post="/pairing" { (w(Word::NewCode)) }
        }
    }
}
