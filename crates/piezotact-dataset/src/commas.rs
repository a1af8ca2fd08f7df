//! What commas in the numbers of a table stand for: the decimal sign, or separators of thousands.

/// What a comma in a number stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Commas {
    /// `7,5` is seven and a half.
    Decimal,
    /// `7,382` is seven thousand three hundred and eighty-two.
    Thousands,
}

/// What the numbers of a table say about its commas.
#[derive(Clone, Debug, Default)]
pub(crate) struct CommaEvidence {
    /// A number whose comma can only be the decimal sign: `0,5`, `1234,5`, `1.234,5`.
    decimal: bool,
    /// A number whose commas can only separate thousands: `1,234,567`, `7,382.5`.
    thousands: bool,
    /// The first number whose comma can be either: `7,382`.
    either: Option<String>,
    /// The first whole number below 1000 without a comma: `988`.
    small: Option<String>,
    /// A whole number from 1000 without a comma.
    large: bool,
}

impl CommaEvidence {
    /// Takes in a cell; what is no number says nothing.
    pub(crate) fn add(&mut self, cell: &str) {
        let digits = cell.trim().trim_start_matches(['+', '-', '−']);
        if !digits.starts_with(|sign: char| sign.is_ascii_digit()) {
            return;
        }
        let Some(comma) = digits.find(',') else {
            let whole = digits.bytes().all(|byte| byte.is_ascii_digit());
            match whole.then_some(digits.len()) {
                Some(1..=3) if self.small.is_none() => self.small = Some(cell.trim().to_owned()),
                Some(4..) => self.large = true,
                _ => {}
            }
            return;
        };
        let (whole, fraction) = match digits.rfind('.') {
            Some(point) if point > comma => (&digits[..point], Some(&digits[point + 1..])),
            Some(_) => return self.decimal = true,
            None => (digits, None),
        };
        let mut groups = whole.split(',');
        let first = groups.next().unwrap_or_default();
        let three = |group: &str| group.len() == 3 && group.bytes().all(|b| b.is_ascii_digit());
        let grouped =
            (1..=3).contains(&first.len()) && !first.starts_with('0') && groups.all(three);
        match (
            grouped,
            fraction.is_some() || whole.matches(',').count() > 1,
        ) {
            (true, true) => self.thousands = true,
            (true, false) if self.either.is_none() => self.either = Some(cell.trim().to_owned()),
            (true, false) => {}
            (false, _) => self.decimal = true,
        }
    }

    /// A number that can have a separator, and a smaller whole number without one.
    fn beside(&self) -> Option<(String, String)> {
        match (&self.either, &self.small) {
            (Some(either), Some(small)) if !self.large => Some((either.clone(), small.clone())),
            _ => None,
        }
    }

    /// What the commas of a table stand for, from the evidence of its columns, with two numbers of one column that show it where
    /// they separate thousands: the decimal sign, unless every number with a comma can have separators, and one must, or stands
    /// beside smaller whole numbers of its column without a comma.
    pub(crate) fn commas(columns: &[Self]) -> (Commas, Option<(String, String)>) {
        let beside = columns.iter().find_map(Self::beside);
        let thousands = beside.is_some() || columns.iter().any(|column| column.thousands);
        match thousands && !columns.iter().any(|column| column.decimal) {
            true => (Commas::Thousands, beside),
            false => (Commas::Decimal, None),
        }
    }
}

/// A number with commas of this kind; `None` for what is none.
pub(crate) fn number(cell: &str, commas: Commas) -> Option<f64> {
    if !cell.contains(',') {
        return cell.parse().ok();
    }
    match commas {
        Commas::Thousands => cell.replace(',', "").parse().ok(),
        // Points before a decimal comma separate thousands.
        Commas::Decimal if cell.rfind('.') < cell.find(',') => {
            cell.replace('.', "").replace(',', ".").parse().ok()
        }
        Commas::Decimal => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(cells: &[&str], expected: Commas) {
        let mut evidence = CommaEvidence::default();
        cells.iter().for_each(|cell| evidence.add(cell));
        assert_eq!(CommaEvidence::commas(&[evidence]).0, expected, "{cells:?}");
    }

    #[test]
    fn what_the_numbers_show_decides() {
        check(&["-7,382", "988"], Commas::Thousands);
        check(&["1,234,567", "12.5"], Commas::Thousands);
        check(&["7,382.5"], Commas::Thousands);
        // one number with fewer digits, or with a zero in front, shows decimals
        check(&["-7,382", "988", "0,5"], Commas::Decimal);
        check(&["7,382", "988", "0,123"], Commas::Decimal);
        check(&["7,382", "988", "1.234,5"], Commas::Decimal);
        // with separators, 12345 would have one
        check(&["7,382", "988", "12345"], Commas::Decimal);
        // three decimals throughout, as programs write them
        check(&["7,382", "8,100", "9,000"], Commas::Decimal);
        check(&["", "x", "-", "NaN"], Commas::Decimal);
    }

    #[test]
    fn numbers_are_read_as_their_commas_say() {
        let of = |cell, commas| number(cell, commas);
        assert_eq!(of("-7,382", Commas::Thousands), Some(-7382.0));
        assert_eq!(of("7,382.5", Commas::Thousands), Some(7382.5));
        assert_eq!(of("-7,382", Commas::Decimal), Some(-7.382));
        assert_eq!(of("1.234,5", Commas::Decimal), Some(1234.5));
        assert_eq!(of("1,234.5", Commas::Decimal), None);
        assert_eq!(of("1,2,3", Commas::Decimal), None);
        assert_eq!(of("1.5e3", Commas::Decimal), Some(1500.0));
    }
}
