//! Numbers in words: with the digits that count, and minus signs that are ones.

/// `value` with three digits that count.
///
/// ```
/// use piezotact::number::digits;
/// assert_eq!([digits(12345.0), digits(0.012345), digits(-0.0)], ["12345", "0.0123", "0.00"]);
/// ```
#[must_use]
pub fn digits(value: f64) -> String {
    digits_that_count(value, 3)
}

/// `value` with three digits that count, and its sign.
///
/// ```
/// use piezotact::number::digits_signed;
/// assert_eq!([digits_signed(0.5), digits_signed(-12345.0)], ["+0.500", "−12345"]);
/// ```
#[must_use]
pub fn digits_signed(value: f64) -> String {
    let sign = if value < 0.0 { "−" } else { "+" };
    format!("{sign}{}", digits(value.abs()))
}

/// `value` with `count` digits that count; as a power of ten below 1e-4 and from 1e6.
///
/// ```
/// use piezotact::number::digits_that_count;
/// assert_eq!(digits_that_count(1.23456e7, 4), "1.235e7");
/// ```
#[must_use]
pub fn digits_that_count(value: f64, count: u32) -> String {
    // A negative zero is a zero.
    let value = value + 0.0;
    let most = f64::from(count) - 1.0;
    let before = if value == 0.0 {
        0.0
    } else {
        value.abs().log10().floor()
    };
    if (-4.0..6.0).contains(&before) {
        let decimals = (most - before).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", most as usize)
    }
}

/// `value` with six digits that count at most, and no zeros behind the last: for a number that is quoted or computed, of which
/// nothing is known. As a power of ten below 1e-4 and from 1e6.
///
/// ```
/// use piezotact::number::rounded;
/// assert_eq!([rounded(2.44140625), rounded(0.3), rounded(48_000.0)], ["2.44141", "0.3", "48000"]);
/// assert_eq!([rounded(1e-12), rounded(0.1 + 0.2), rounded(-0.0)], ["1e-12", "0.3", "0"]);
/// ```
#[must_use]
pub fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let text = digits_that_count(value, 6);
    let (mantissa, power) = match text.split_once('e') {
        Some((mantissa, power)) => (mantissa, format!("e{power}")),
        None => (text.as_str(), String::new()),
    };
    let short = match mantissa.contains('.') {
        true => mantissa.trim_end_matches('0').trim_end_matches('.'),
        false => mantissa,
    };
    format!("{short}{power}")
}

/// A difference of levels, dB, with its sign and two decimals; what rounds to nothing has no sign.
///
/// ```
/// use piezotact::number::difference_db;
/// assert_eq!([difference_db(-1.234), difference_db(-0.001), difference_db(2.0)], ["−1.23", "0.00", "+2.00"]);
/// ```
#[must_use]
pub fn difference_db(value_db: f64) -> String {
    plus(value_db, 2)
}

/// `value` with `decimals` decimals and its sign, also above zero; what rounds to nothing has no sign.
///
/// ```
/// use piezotact::number::plus;
/// assert_eq!([plus(-1.26, 1), plus(-0.01, 1), plus(2.0, 0)], ["−1.3", "0.0", "+2"]);
/// ```
#[must_use]
pub fn plus(value: f64, decimals: usize) -> String {
    let text = signed(value, decimals);
    match text.chars().any(|c| matches!(c, '1'..='9')) {
        true if !text.starts_with('−') => format!("+{text}"),
        _ => text,
    }
}

/// `count` with the noun for it, `what`, in the plural where it is not one.
///
/// ```
/// use piezotact::number::counted;
/// assert_eq!([counted(1, "sample"), counted(25, "sample")], ["1 sample", "25 samples"]);
/// ```
#[must_use]
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// `value` with `decimals` decimals and a minus sign that is one; what rounds to nothing has no sign.
///
/// ```
/// use piezotact::number::signed;
/// assert_eq!([signed(-1.26, 1), signed(-0.01, 1), signed(2.0, 0)], ["−1.3", "0.0", "2"]);
/// ```
#[must_use]
pub fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| matches!(c, '0' | '.')) => zero.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// A probability `p`, from 0 to 1.
///
/// ```
/// use piezotact::number::p_text;
/// assert_eq!([p_text(0.0001), p_text(0.0421), p_text(0.5)], ["p < 0.001", "p = 0.042", "p = 0.50"]);
/// ```
#[must_use]
pub fn p_text(p: f64) -> String {
    match p {
        p if p < 0.001 => "p < 0.001".into(),
        p if p < 0.1 => format!("p = {p:.3}"),
        p => format!("p = {p:.2}"),
    }
}
