//! What commas and points in the numbers of a table stand for: the decimal sign, or separators of thousands.

/// What a sign in a number stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// `7,5` is seven and a half.
    Decimal,
    /// `7,382` is seven thousand three hundred and eighty-two.
    Thousands,
}

/// What the signs in the numbers of a table stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signs {
    pub(crate) comma: Meaning,
    pub(crate) point: Meaning,
}

impl Signs {
    /// Points are decimal signs, and there are no commas.
    pub(crate) const POINTS: Self = Self {
        comma: Meaning::Thousands,
        point: Meaning::Decimal,
    };

    /// The number in a cell; `None` for what is none.
    pub(crate) fn number(self, cell: &str) -> Option<f64> {
        if !cell.contains([',', '.']) {
            return cell.parse().ok();
        }
        match (self.comma, self.point) {
            (Meaning::Thousands, Meaning::Decimal) => without(cell, ',').parse().ok(),
            (Meaning::Decimal, Meaning::Thousands) => decimal_comma(&without(cell, '.')),
            // A table that mixes both: points before a comma separate thousands.
            (Meaning::Decimal, Meaning::Decimal) if cell.rfind('.') < cell.find(',') => {
                decimal_comma(&without(cell, '.'))
            }
            (Meaning::Decimal, Meaning::Decimal) if !cell.contains(',') => cell.parse().ok(),
            _ => None,
        }
    }
}

fn without(cell: &str, sign: char) -> String {
    cell.replace(sign, "")
}

fn decimal_comma(cell: &str) -> Option<f64> {
    cell.replacen(',', ".", 1).parse().ok()
}

/// As many numbers of a column whose points can separate thousands, and none whose point cannot, are no chance: of decimals with
/// their zeros left out, one in ten is shorter.
const SURE: usize = 30;

/// What the numbers of a column say about one sign.
#[derive(Clone, Debug, Default)]
struct OfSign {
    /// The first number in which the sign can only be the decimal one: `0,5`, `1234,5`, `1.234,5`.
    decimal: Option<String>,
    /// The first number in which it can only separate thousands: `1,234,567`, `7,382.5`.
    thousands: Option<String>,
    /// The first number in which it can be either, `7,382`, and how many there are.
    either: Option<String>,
    count: usize,
}

/// What the numbers of a column say.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evidence {
    comma: OfSign,
    point: OfSign,
    /// The first whole number below 1000 without a sign: `988`.
    small: Option<String>,
    /// A whole number from 1000 without a sign.
    large: bool,
}

impl Evidence {
    /// Takes in a cell; what is no number says nothing.
    pub(crate) fn add(&mut self, cell: &str) {
        let cell = cell.trim();
        let digits = cell.trim_start_matches(['+', '-', '−']);
        let is_digit = |c: char| c.is_ascii_digit();
        let (digits, exponent) = match digits.split_once(['e', 'E']) {
            Some((digits, _)) => (digits, true),
            None => (digits, false),
        };
        let of_a_number = |c: char| c.is_ascii_digit() || c == ',' || c == '.';
        if !digits.contains(is_digit) || !digits.chars().all(of_a_number) {
            return;
        }
        let count = |sign: char| digits.matches(sign).count();
        let (commas, points) = (count(','), count('.'));
        match (commas, points) {
            (0, 0) => match digits.len() {
                1..=3 if self.small.is_none() => self.small = Some(cell.to_owned()),
                4.. => self.large = true,
                _ => {}
            },
            (_, 0) => self.comma.add(cell, digits, ',', (commas, exponent)),
            (0, _) => self.point.add(cell, digits, '.', (points, exponent)),
            _ => {
                let comma_last = digits.rfind(',') > digits.rfind('.');
                let (last, first) = match comma_last {
                    true => (&mut self.comma, &mut self.point),
                    false => (&mut self.point, &mut self.comma),
                };
                last.decimal.get_or_insert_with(|| cell.to_owned());
                first.thousands.get_or_insert_with(|| cell.to_owned());
            }
        }
    }

    /// A number whose `sign` can separate thousands, and a smaller whole number without it, where no larger one is without it.
    fn beside<'a>(&'a self, sign: &'a OfSign) -> Option<(&'a str, &'a str)> {
        let both = sign.either.as_deref().zip(self.small.as_deref());
        both.filter(|_| !self.large)
    }
}

impl OfSign {
    /// Takes in `digits` with so many of `sign` and no other sign.
    fn add(&mut self, cell: &str, digits: &str, sign: char, (count, exponent): (usize, bool)) {
        let mut groups = digits.split(sign);
        let first = groups.next().unwrap_or_default();
        let grouped = (1..=3).contains(&first.len())
            && !first.starts_with('0')
            && groups.all(|group| group.len() == 3)
            && !exponent;
        let found = match (grouped, count) {
            (true, 1) => {
                self.count += 1;
                &mut self.either
            }
            (true, _) => &mut self.thousands,
            (false, 1) => &mut self.decimal,
            // What has several and no groups of three is no number.
            (false, _) => return,
        };
        found.get_or_insert_with(|| cell.to_owned());
    }
}

/// What the signs of a table stand for, from the evidence of its columns, and in words what a person should know of it. A table has
/// one decimal sign, so that the other one separates thousands wherever it can; where each is somewhere a decimal sign for
/// certain, both are. Where nothing is certain, a comma is the decimal sign, and so is a point, unless numbers with it stand beside
/// smaller whole numbers without it in their column. Points that separate thousands are looked for where columns are not
/// separated by commas.
///
/// # Errors
/// [`Ambiguous`] where both signs stand before three digits and nothing says which is which: a factor of 1000 hangs on it.
pub(crate) fn signs_of(
    columns: &[Evidence],
    delimiter: u8,
) -> Result<(Signs, Option<String>), Ambiguous> {
    let (comma, point) = (
        columns.iter().find_map(|c| c.comma.either.as_ref()),
        columns.iter().find_map(|c| c.point.either.as_ref()),
    );
    let certain = |of: &OfSign| of.decimal.is_some() || of.thousands.is_some();
    let nothing_certain = !columns
        .iter()
        .any(|c| certain(&c.comma) || certain(&c.point) || c.beside(&c.comma).is_some());
    match (comma, point) {
        (Some(comma), Some(point)) if nothing_certain => Err(Ambiguous {
            comma: comma.clone(),
            point: point.clone(),
        }),
        _ => Ok(known_signs(columns, delimiter)),
    }
}

/// Two numbers of a table with different signs, either of which can separate thousands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Ambiguous {
    pub(crate) comma: String,
    pub(crate) point: String,
}

/// As [`signs_of`], where the table holds one sign alone or says what one of them is.
fn known_signs(columns: &[Evidence], delimiter: u8) -> (Signs, Option<String>) {
    let first = |of: fn(&Evidence) -> Option<&String>| columns.iter().find_map(of);
    let comma = first(|c| c.comma.decimal.as_ref());
    let point = first(|c| c.point.decimal.as_ref());
    let thousands = |sign: &str, shown: String| {
        Some(format!(
            "{sign} in the numbers are read as separators of thousands ({shown})"
        ))
    };
    let grouped_comma = first(|c| c.comma.thousands.as_ref().or(c.comma.either.as_ref()));
    let grouped_point = first(|c| c.point.thousands.as_ref().or(c.point.either.as_ref()));
    let decimal_commas = Signs {
        comma: Meaning::Decimal,
        point: Meaning::Thousands,
    };
    let both = Signs {
        comma: Meaning::Decimal,
        point: Meaning::Decimal,
    };
    match (comma, point) {
        (Some(comma), Some(point)) => {
            let said = format!(
                "both commas and points are read as decimal signs (`{comma}` and `{point}`)"
            );
            (both, Some(said))
        }
        (Some(comma), None) => {
            let said = grouped_point.and_then(|grouped| {
                thousands(
                    "points",
                    format!("`{grouped}`, as `{comma}` has a decimal comma"),
                )
            });
            (decimal_commas, said)
        }
        (None, Some(point)) => {
            let said = grouped_comma.and_then(|grouped| {
                let small = columns.iter().find_map(|c| c.beside(&c.comma));
                let shown = match small {
                    Some((large, small)) => format!("`{large}` beside `{small}`"),
                    None => format!("`{grouped}`, as `{point}` has a decimal point"),
                };
                thousands("commas", shown)
            });
            (Signs::POINTS, said)
        }
        (None, None) => {
            let beside = columns.iter().find_map(|c| c.beside(&c.comma));
            let certain = first(|c| c.comma.thousands.as_ref());
            if let Some((large, small)) = beside {
                return (
                    Signs::POINTS,
                    thousands("commas", format!("`{large}` beside `{small}`")),
                );
            }
            if let Some(certain) = certain {
                return (Signs::POINTS, thousands("commas", format!("`{certain}`")));
            }
            let mut sure = columns.iter().filter(|c| c.point.count >= SURE);
            let beside = sure.find_map(|c| c.beside(&c.point));
            match beside.filter(|_| delimiter != b',') {
                Some((large, small)) => (
                    decimal_commas,
                    thousands("points", format!("`{large}` beside `{small}`")),
                ),
                None => (both, None),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signs(cells: &[&str]) -> (Signs, Option<String>) {
        let mut evidence = Evidence::default();
        cells.iter().for_each(|cell| evidence.add(cell));
        signs_of(&[evidence], b';').unwrap()
    }

    #[track_caller]
    fn check(cells: &[&str], comma: Meaning) {
        assert_eq!(signs(cells).0.comma, comma, "{cells:?}");
    }

    #[test]
    fn what_the_numbers_show_decides() {
        check(&["-7,382", "988"], Meaning::Thousands);
        check(&["1,234,567", "12.5"], Meaning::Thousands);
        check(&["7,382.5"], Meaning::Thousands);
        // one number with fewer digits, or with a zero in front, shows decimals
        check(&["-7,382", "988", "0,5"], Meaning::Decimal);
        check(&["7,382", "988", "0,123"], Meaning::Decimal);
        check(&["7,382", "988", "1.234,5"], Meaning::Decimal);
        // with separators, 12345 would have one
        check(&["7,382", "988", "12345"], Meaning::Decimal);
        // three decimals throughout, as programs write them
        check(&["7,382", "8,100", "9,000"], Meaning::Decimal);
        check(&["", "x", "-", "NaN"], Meaning::Decimal);
    }

    /// A table has one decimal sign: that of its times tells what the other one is in its values.
    #[test]
    fn the_other_sign_separates_thousands() {
        let columns = |time: &[&str], values: &[&str]| {
            let [time, values] = [time, values].map(|cells| {
                let mut evidence = Evidence::default();
                cells.iter().for_each(|cell| evidence.add(cell));
                evidence
            });
            signs_of(&[time, values], b';').unwrap()
        };
        let (signs, said) = columns(&["0.000", "0.001"], &["1,500", "1,610"]);
        assert_eq!(signs.number("1,500"), Some(1500.0));
        assert!(said.unwrap().contains("`1,500`, as `0.000` has"));
        let (signs, said) = columns(&["0,000", "0,001"], &["1.064", "2.106"]);
        assert_eq!(
            [signs.number("1.064"), signs.number("0,001")],
            [Some(1064.0), Some(0.001)]
        );
        assert!(said.unwrap().contains("points"));
        // A value that cannot have separators: both are decimal signs.
        let (signs, said) = columns(&["0,000", "0,001"], &["1.064", "0.106"]);
        assert_eq!(signs.number("1.064"), Some(1.064));
        assert!(said.unwrap().contains("both"));
        // Without commas, three decimals are three decimals.
        let (signs, said) = columns(&["0.000", "0.001"], &["1.064", "2.106"]);
        assert_eq!((signs.number("1.064"), said), (Some(1.064), None));
    }

    /// A time from 1 s on, in ms, beside thousands, all with three digits: nothing says which sign is which.
    #[test]
    fn two_signs_that_can_both_separate_thousands_are_refused() {
        let of = |cells: &[&str]| {
            let mut evidence = Evidence::default();
            cells.iter().for_each(|cell| evidence.add(cell));
            signs_of(&[evidence], b';')
        };
        let refused = of(&["1.002", "1,705", "1.003", "1,610"]).unwrap_err();
        assert_eq!([refused.comma, refused.point], ["1,705", "1.002"]);
        assert!(of(&["1.002", "1,705", "0.5"]).is_ok());
        assert!(of(&["1.002", "1,705", "999"]).is_ok());
        assert!(of(&["1,002", "1,705"]).is_ok());
    }

    /// Points between whole numbers: a few can be chance, many not.
    #[test]
    fn many_points_beside_smaller_whole_numbers_separate_thousands() {
        let large: Vec<String> = (0..40).map(|i| format!("1.{:03}", 101 + 9 * i)).collect();
        let mut cells: Vec<&str> = large.iter().map(String::as_str).collect();
        cells.push("837");
        assert_eq!(signs(&cells).0.number("1.101"), Some(1101.0));
        assert_eq!(signs(&cells[20..]).0.number("1.101"), Some(1.101));
        cells.push("1.5");
        assert_eq!(signs(&cells).0.number("1.101"), Some(1.101));
    }

    #[test]
    fn numbers_are_read_as_their_signs_say() {
        let signs = |comma, point| Signs { comma, point };
        use Meaning::{Decimal, Thousands};
        let points = signs(Thousands, Decimal);
        assert_eq!(points.number("-7,382"), Some(-7382.0));
        assert_eq!(points.number("7,382.5"), Some(7382.5));
        let both = signs(Decimal, Decimal);
        assert_eq!(both.number("-7,382"), Some(-7.382));
        assert_eq!(both.number("1.234,5"), Some(1234.5));
        assert_eq!(both.number("1,234.5"), None);
        assert_eq!(both.number("1,2,3"), None);
        assert_eq!(both.number("1.5e3"), Some(1500.0));
        assert_eq!(signs(Decimal, Thousands).number("1.234,5"), Some(1234.5));
    }
}
