//! What of people may stand in a data set that others open: shifted dates, ages that are not rare, and no words that somebody typed.

use piezotact::quantity::Seconds;
use piezotact::recording::{BenchKind, StartTime};
use piezotact::warning::Warning;
use serde_json::{Map, Value};

/// From this age on all have this one.
///
/// Source: BIDS 1.11, participants file; 45 CFR 164.514(b)(2)(i)(C), which names ages over 89.
const OLDEST: u32 = 89;
/// Days from 1900-01-01 to 1970-01-01.
const TO_1970: i64 = 25_567;
const DAY_MS: i64 = 86_400_000;

/// The calendar of one participant: whole days earlier than the true one, so that the first day is 1900-01-01. Times of day and the
/// time between sessions stay.
///
/// Source: BIDS 1.11, scans file: dates may be shifted, for all files of a participant alike, and are then before 1925.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calendar {
    days: i64,
}

impl Calendar {
    /// The calendar of somebody whose first session was begun `first_ms` after 1970-01-01 00:00 UTC.
    #[must_use]
    pub fn beginning(first_ms: i64) -> Self {
        Self {
            days: first_ms.div_euclid(DAY_MS) + TO_1970,
        }
    }

    /// The ms from 1970-01-01 00:00 to a start time: in UTC, or on the clock of an unknown time zone.
    #[must_use]
    pub fn ms_since_1970(started: &StartTime) -> Option<i64> {
        let text = String::from(started.clone());
        match is_in_zone(&text) {
            true => started.unix_ms(),
            false => ms_of(&text),
        }
    }

    /// `at_ms` on this calendar, both in ms since 1970-01-01 00:00 UTC.
    #[must_use]
    pub fn shifted_ms(self, at_ms: i64) -> i64 {
        at_ms - self.days * DAY_MS
    }

    /// `at_ms` on this calendar as BIDS has times in UTC: `1900-01-01T10:22:33.250Z`.
    #[must_use]
    pub fn text(self, at_ms: i64) -> String {
        text_of(self.shifted_ms(at_ms))
    }

    /// The start time of a recording on this calendar, in UTC; of a clock in an unknown time zone its own time of day, without `Z`.
    #[must_use]
    pub fn start(self, started: &StartTime) -> String {
        let text = String::from(started.clone());
        if let (true, Some(at_ms)) = (is_in_zone(&text), started.unix_ms()) {
            return self.text(at_ms);
        }
        let shift_s = (self.days * DAY_MS / 1000) as f64;
        let shifted = String::from(started.later(Seconds(-shift_s)));
        // BIDS has six decimals at most.
        let end = shifted
            .find('.')
            .map_or(shifted.len(), |dot| (dot + 7).min(shifted.len()));
        shifted[..end].to_owned()
    }
}

/// Whether a start time states its time zone.
fn is_in_zone(text: &str) -> bool {
    text.ends_with('Z') || text.get(19..).is_some_and(|rest| rest.contains(['+', '-']))
}

/// A time in ms since 1970-01-01 00:00 UTC as BIDS has times in UTC.
pub(super) fn text_of(at_ms: i64) -> String {
    let zero = StartTime::try_from("1970-01-01T00:00:00".to_owned());
    // Whole seconds are exact as floating point.
    let (seconds, ms) = (at_ms.div_euclid(1000), at_ms.rem_euclid(1000));
    let mut text = zero.map_or_else(
        |_never| String::new(),
        |zero| String::from(zero.later(Seconds(seconds as f64))),
    );
    if ms > 0 {
        text.push_str(&format!(".{ms:03}"));
    }
    text.push('Z');
    text
}

/// The time `text` in ms since 1970-01-01 00:00 UTC, also before 1970; `None` where it is no time.
pub(super) fn ms_of(text: &str) -> Option<i64> {
    let at = StartTime::try_from(text.trim_end_matches('Z').to_owned()).ok()?;
    let zero = StartTime::try_from("1970-01-01T00:00:00".to_owned()).ok()?;
    Some((at.seconds_since(&zero).0 * 1000.0).round() as i64)
}

/// An age in years as it may stand there: 89 for everybody of 89 or more.
#[must_use]
pub(super) fn age_of(age_years: u32) -> u32 {
    age_years.min(OLDEST)
}

/// The sex as BIDS has it (F, M, O), of the word that somebody stated in English, French or Italian; `None` for another word.
#[must_use]
pub(super) fn sex_of(stated: &str) -> Option<&'static str> {
    match stated.trim().to_lowercase().as_str() {
        "f" | "female" | "woman" | "w" | "femme" | "féminin" | "donna" | "femmina"
        | "femminile" => Some("F"),
        "m" | "male" | "man" | "homme" | "h" | "masculin" | "uomo" | "maschio" | "maschile" => {
            Some("M")
        }
        "o" | "other" | "autre" | "altro" | "non-binary" | "nonbinary" | "diverse" => Some("O"),
        _ => None,
    }
}

/// Words that tell nobody: fingers and hands in English, French and Italian.
const FINGERS: [&str; 34] = [
    "right",
    "left",
    "dominant",
    "non-dominant",
    "index",
    "middle",
    "ring",
    "little",
    "thumb",
    "finger",
    "hand",
    "of",
    "the",
    "droit",
    "droite",
    "gauche",
    "majeur",
    "annulaire",
    "auriculaire",
    "pouce",
    "doigt",
    "main",
    "destro",
    "destra",
    "sinistro",
    "sinistra",
    "indice",
    "medio",
    "anulare",
    "mignolo",
    "pollice",
    "dito",
    "mano",
    "forefinger",
];

/// Whether `text` holds nothing but words for fingers.
pub(super) fn is_finger(text: &str) -> bool {
    let lower = text.to_lowercase();
    let mut words = lower.split_whitespace().peekable();
    words.peek().is_some() && words.all(|word| FINGERS.contains(&word))
}

/// Whether `text` has the form of a tag of a language (BCP 47), such as `fr` or `fr-CH`.
pub(super) fn is_language(text: &str) -> bool {
    let mut parts = text.split('-');
    let fits = |part: &str, len: std::ops::RangeInclusive<usize>| {
        len.contains(&part.len()) && part.chars().all(|sign| sign.is_ascii_alphanumeric())
    };
    parts.next().is_some_and(|part| fits(part, 2..=3)) && parts.all(|part| fits(part, 2..=4))
}

/// The handedness as BIDS has it (R, L, A), of the word that a session keeps.
#[must_use]
pub(super) fn handedness_of(stated: &str) -> Option<&'static str> {
    match stated.trim().to_lowercase().as_str() {
        "right" | "r" => Some("R"),
        "left" | "l" => Some("L"),
        "both" | "ambidextrous" | "a" => Some("A"),
        _ => None,
    }
}

/// What a folder and a name of a user would tell: of a path its last part.
pub(super) fn without_folders(text: &str) -> String {
    let words = text.split(' ').map(|word| {
        let has_file = word.rsplit(['/', '\\']).next().is_some_and(|last| {
            let ending = last.rsplit_once('.').map(|(_, ending)| ending);
            ending.is_some_and(|ending| ending.starts_with(|sign: char| sign.is_ascii_alphabetic()))
        });
        let is_path = word.starts_with('/')
            || word.starts_with("~/")
            || word.starts_with("../")
            || word.starts_with("file:")
            || word.contains('\\')
            || (word.contains('/') && has_file)
            || (word.matches('/').count() > 1 && !word.contains("//"));
        match is_path {
            true => word.rsplit(['/', '\\']).next().unwrap_or_default(),
            false => word,
        }
    });
    words.collect::<Vec<_>>().join(" ")
}

/// A text of a recording as it may be carried: without folders; `None` where it holds a date, an address or a number of a telephone.
pub(super) fn carried(text: &str) -> Option<String> {
    personal(text).is_none().then(|| without_folders(text))
}

/// Words in names of channels and events that tell nobody.
const COMMON: &str = "accel acceleration accelerometer active baseline begin blink boundary button cell channel \
    comment contact control count counts current degrees displacement drive edge electrode event \
    exhale finger fingernail fixation force heog heogl heogr horizontal imagery impedance index \
    inhale interval left lift load marker mastoid microphone motion nail natural normal onset output \
    passive pause physio position press pressure pulse record rejected response rest right sensor \
    signal skin slide sound speed start status stim stimulus stop stroke sync tangential task \
    temperature touch trial trig trigger velocity veog veogl veogu vertical vibration voltage volume \
    wrist";

/// Whether `text` holds a word of more than three letters that may be somebody's name.
pub(super) fn has_unknown_word(text: &str) -> bool {
    let words = text.split(|sign: char| !sign.is_alphabetic());
    let mut words = words.filter(|word| word.chars().count() > 3);
    words.any(|word| {
        let word = word.to_lowercase();
        !COMMON.split(' ').any(|common| common == word)
    })
}

/// Fields of warnings whose words are the program's own.
const OWN_WORDS: [&str; 7] = ["at", "by", "fault", "how", "of", "role", "why"];
/// A larger number may be a date or a number of a telephone.
const LARGEST: f64 = 1e8;

/// The warnings about what was measured on `bench` as they may be carried: of another program's without words, which may hold the names of
/// its channels, events and files.
#[must_use]
pub fn warnings_carried(bench: Option<BenchKind>, warnings: Vec<Warning>) -> Vec<Warning> {
    if bench.is_some() {
        return warnings;
    }
    warnings.into_iter().map(without_words).collect()
}

fn without_words(warning: Warning) -> Warning {
    let fields: Map<String, Value> = (warning.fields.into_iter())
        .filter(|(name, value)| match value {
            Value::Bool(_) => true,
            Value::Number(number) => number.as_f64().is_some_and(|x| x.abs() < LARGEST),
            Value::String(word) => {
                let is_tag = |sign: char| sign.is_ascii_lowercase() || sign == '_';
                OWN_WORDS.contains(&name.as_str()) && word.chars().all(is_tag)
            }
            _ => false,
        })
        .collect();
    Warning {
        text: format!(
            "`{}` (its sentence may hold names of the original file and is left out): see docs/guide/warnings.md",
            warning.code
        ),
        code: warning.code,
        fields,
        seen: warning.seen,
    }
}

/// Words of which one in the name of a column says that it holds who somebody is.
const WHO: [&str; 34] = [
    "firstname",
    "lastname",
    "surname",
    "forename",
    "fullname",
    "realname",
    "cognome",
    "prenom",
    "prénom",
    "prenoms",
    "birthday",
    "birthdate",
    "birthyear",
    "birthplace",
    "dob",
    "dateofbirth",
    "email",
    "emails",
    "ssn",
    "vorname",
    "nachname",
    "geburtsdatum",
    "geburtstag",
    "apellido",
    "apellidos",
    "initials",
    "fname",
    "lname",
    "passport",
    "postcode",
    "telefono",
    "имя",
    "名前",
    "氏名",
];

/// Words that say it alone or beside those of [`OF_A_PERSON`]: a scanner has a name too.
const WHO_OF_A_PERSON: [&str; 25] = [
    "name",
    "names",
    "nom",
    "nome",
    "namn",
    "nombre",
    "nombres",
    "maiden",
    "birth",
    "naissance",
    "nascita",
    "mail",
    "phone",
    "telephone",
    "mobile",
    "tel",
    "address",
    "adresse",
    "indirizzo",
    "contact",
    "insurance",
    "street",
    "city",
    "zip",
    "identity",
];

/// Words beside which those of [`WHO_OF_A_PERSON`] are about a person.
const OF_A_PERSON: [&str; 33] = [
    "first",
    "last",
    "full",
    "family",
    "given",
    "real",
    "legal",
    "own",
    "participant",
    "participants",
    "subject",
    "patient",
    "person",
    "volunteer",
    "middle",
    "maiden",
    "date",
    "day",
    "month",
    "year",
    "place",
    "of",
    "de",
    "di",
    "the",
    "number",
    "no",
    "nr",
    "home",
    "work",
    "private",
    "e",
    "code",
];

/// Whether a column called `name` tells who somebody is.
pub(super) fn tells_who(name: &str) -> bool {
    let mut words: Vec<String> = Vec::new();
    let mut word = String::new();
    let mut before = ' ';
    for sign in name.chars() {
        let new = !sign.is_alphanumeric() || (sign.is_uppercase() && before.is_lowercase());
        if new && !word.is_empty() {
            words.push(std::mem::take(&mut word));
        }
        if sign.is_alphanumeric() {
            word.extend(sign.to_lowercase());
        }
        before = sign;
    }
    words.push(word);
    let words: Vec<&str> = words
        .iter()
        .map(|word| word.trim_end_matches(|sign: char| sign.is_ascii_digit()))
        .filter(|word| !word.is_empty())
        .collect();
    let (of_who, others): (Vec<&str>, Vec<&str>) =
        (words.iter().copied()).partition(|word| WHO_OF_A_PERSON.contains(word));
    words.iter().any(|word| WHO.contains(word))
        || (!of_who.is_empty() && others.iter().all(|word| OF_A_PERSON.contains(word)))
}

/// The same of a table in which samples and stimuli have names too: a name alone tells nobody.
pub(super) fn tells_who_beside_stimuli(name: &str) -> bool {
    let is_name = [
        "name", "names", "nom", "nome", "code", "contact", "city", "identity",
    ];
    tells_who(name) && !is_name.contains(&name.to_lowercase().as_str())
}

/// What a cell holds that would tell who somebody is.
///
/// Digits alone may be a date or a number of a telephone, and are looked at by [`personal_in_people`].
pub(super) fn personal(cell: &str) -> Option<&'static str> {
    let is_number = cell
        .chars()
        .all(|sign| sign.is_ascii_digit() || sign == '+');
    match is_number {
        true => None,
        false => personal_in_people(cell),
    }
}

/// The same in a table of people.
pub(super) fn personal_in_people(cell: &str) -> Option<&'static str> {
    let apart = |sign: char| sign.is_whitespace() || "()<>[],;".contains(sign);
    let mut parts = cell.split(apart);
    let digits = cell.chars().filter(char::is_ascii_digit).count();
    if parts.clone().any(is_mail) {
        return Some("an address of electronic mail");
    }
    if cell.trim().starts_with('+') && digits >= 9 && !cell.contains('.') {
        return Some("a number of a telephone");
    }
    parts.any(is_date).then_some("a date")
}

fn is_mail(part: &str) -> bool {
    let at = part.find('@');
    at.is_some_and(|at| at > 0 && part[at..].contains('.'))
}

/// Whether it is a date that is not shifted: `1990-05-17`, `17/05/1990`, `17.05.1990`, `17/05/90`, `19900517`.
fn is_date(part: &str) -> bool {
    let day = part.split('T').next().unwrap_or_default();
    let number = |text: &str, len: std::ops::RangeInclusive<usize>| {
        len.contains(&text.len()) && text.chars().all(|sign| sign.is_ascii_digit())
    };
    let up_to = |text: &str, most: u32| (1..=most).contains(&text.parse().unwrap_or(0));
    if number(day, 8..=8) {
        let is_year = (1926..2100).contains(&day[..4].parse().unwrap_or(0));
        return is_year && up_to(&day[4..6], 12) && up_to(&day[6..], 31);
    }
    let parts: Vec<&str> = day.split(['-', '/', '.', '_']).collect();
    let [first, second, third] = parts.as_slice() else {
        return false;
    };
    let short = |text: &str| number(text, 1..=2) && up_to(text, 31);
    // Before 1926 are dates that were shifted.
    let year = |text: &str| number(text, 4..=4) && text.parse().is_ok_and(|year: u32| year >= 1926);
    let of_century = |text: &str| number(text, 2..=2) && day.contains('/');
    short(second)
        && ((year(first) && short(third)) || (short(first) && (year(third) || of_century(third))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_shifted_and_what_lies_between_stays() {
        // 2026-03-01T10:22:33.250Z
        let first = 1_772_360_553_250;
        let calendar = Calendar::beginning(first);
        assert_eq!(calendar.text(first), "1900-01-01T10:22:33.250Z");
        assert_eq!(
            calendar.text(first + 26 * 3_600_000),
            "1900-01-02T12:22:33.250Z"
        );
        assert_eq!(
            ms_of(&calendar.text(first)),
            Some(calendar.shifted_ms(first))
        );
        let start = |text: &str| StartTime::try_from(text.to_owned()).unwrap();
        assert_eq!(
            calendar.start(&start("2026-03-02T10:22:33+01:00")),
            "1900-01-02T09:22:33Z"
        );
        assert_eq!(
            calendar.start(&start("2026-03-02T10:22:33.123456789")),
            "1900-01-02T10:22:33.123456"
        );
    }

    #[test]
    fn words_that_tell_nobody_are_known() {
        assert!(is_finger("right index") && is_finger("Indice destro"));
        assert!(!is_finger("the finger of Jane") && !is_finger(""));
        assert!(is_language("fr-CH") && is_language("it") && !is_language("Jane"));
    }

    #[test]
    fn who_somebody_is_is_found() {
        for name in [
            "name",
            "name1",
            "Vorname",
            "real_name",
            "firstName",
            "birth_date",
            "date of birth",
            "Prénom",
            "e-mail",
            "DOB",
            "participant_name",
            "phone number",
        ] {
            assert!(tells_who(name), "{name}");
        }
        for name in [
            "age",
            "sex",
            "participant_id",
            "filename",
            "handedness",
            "pseudonym",
            "kind",
            "namespace",
            "scanner_name",
            "birth_weight",
            "phone_use_hours",
        ] {
            assert!(!tells_who(name), "{name}");
        }
        for cell in [
            "1990-05-17",
            "17/05/1990",
            "17.5.1990",
            "17/05/90",
            "19900517",
            "born 1990-05-17",
            "(1990-05-17)",
            "a.b@example.org",
            "A <a@b.org>",
            "+41 79 123 45 67",
        ] {
            assert!(personal_in_people(cell).is_some(), "{cell}");
        }
        for cell in [
            "30",
            "+0.25",
            "12345678",
            "20191399",
            "1.2.3",
            "S2-S4-S8",
            "n/a",
            "2024",
            "1/2/3",
            "1900-01-05",
        ] {
            assert!(personal_in_people(cell).is_none(), "{cell}");
        }
        assert_eq!(
            without_folders("file /home/ab/S2.wav of m/s²"),
            "file S2.wav of m/s²"
        );
        for path in [
            "file:///home/jane/S2.wav",
            "jane/S2.wav",
            r"\\server\jane\S2.wav",
            r"C:\jane\S2.wav",
        ] {
            assert_eq!(without_folders(path), "S2.wav", "{path}");
        }
        assert_eq!(without_folders("in m/s^2 and N/m"), "in m/s^2 and N/m");
        assert_eq!(carried("accel z").as_deref(), Some("accel z"));
        assert_eq!(carried("made on 1990-05-17"), None);
    }
}
