//! Axes: from values to places, and where the ticks are.

/// How values are laid along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Values of 0 and below have no place on it and are not drawn.
    Log,
}

/// A value's mark on an axis; without text it is a minor one.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub value: f64,
    pub label: String,
}

/// A scale with its ends and its length in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    scale: Scale,
    /// In the scale's own coordinate: the value, or its decimal logarithm.
    low: f64,
    high: f64,
    length: f64,
}

impl Axis {
    /// Holds all `values` with a little room at both ends; those without a place on the scale do not count.
    pub fn new(scale: Scale, values: impl Iterator<Item = f64>, length: f64) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for at in values.filter_map(|value| coordinate(scale, value)) {
            (low, high) = (low.min(at), high.max(at));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // One value alone: half a decade, or a unit, to either side.
        let least = if scale == Scale::Log { 0.3 } else { 1e-9 * low.abs().max(high.abs()).max(1e-300) };
        if high - low < least {
            let room = if scale == Scale::Log { 0.5 } else { 0.5 * low.abs().max(1e-9) };
            (low, high) = (low - room, high + room);
        }
        let room = 0.04 * (high - low);
        Axis { scale, low: low - room, high: high + room, length }
    }

    /// Distance from the axis' low end in pixels; `None` for a value that has no place on the scale.
    pub fn place(&self, value: f64) -> Option<f64> {
        Some((coordinate(self.scale, value)? - self.low) / (self.high - self.low) * self.length)
    }

    /// The ends as values.
    pub fn range(&self) -> (f64, f64) {
        match self.scale {
            Scale::Linear => (self.low, self.high),
            Scale::Log => (10f64.powf(self.low), 10f64.powf(self.high)),
        }
    }

    /// Marks in increasing order; labels are at least `room` pixels apart.
    pub fn ticks(&self, room: f64) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(room),
            Scale::Log => self.log_ticks(room),
        }
    }

    /// Steps of 1, 2 or 5 times a power of ten.
    fn linear_ticks(&self, room: f64) -> Vec<Tick> {
        let least = (self.high - self.low) * room / self.length;
        let power = 10f64.powf(least.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= least).unwrap_or(10.0 * power);
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        let largest = self.low.abs().max(self.high.abs());
        let label = |value: f64| match value {
            _ if !(1e-4..1e6).contains(&largest) => format!("{value:.1e}").replace('-', "−"),
            _ => format!("{value:.decimals$}").replace('-', "−"),
        };
        (first..=last).map(|i| i as f64 * step).map(|value| Tick { value, label: label(value) }).collect()
    }

    /// Decades are labelled, every second or third where they are dense; 2 and 5 too where less than two are in view, and
    /// whatever has room where none is.
    fn log_ticks(&self, room: f64) -> Vec<Tick> {
        let pixels = self.length / (self.high - self.low);
        let every = (room / pixels).ceil().max(1.0) as i64;
        let decades = (self.low.floor() as i64)..=(self.high.ceil() as i64);
        let in_view = decades.clone().filter(|&d| (self.low..=self.high).contains(&(d as f64))).count();
        let mut ticks = Vec::new();
        for decade in decades {
            for digit in 1..=9 {
                let at = decade as f64 + f64::from(digit).log10();
                if !(self.low..=self.high).contains(&at) || (digit > 1 && pixels < 14.0) {
                    continue;
                }
                let named = digit == 1 && decade.rem_euclid(every) == 0;
                let named = named || (in_view < 2 && matches!(digit, 1 | 2 | 5) && 0.3 * pixels >= room);
                let to_next = (1.0 + 1.0 / f64::from(digit)).log10() * pixels;
                let named = named || (in_view == 0 && to_next >= room);
                let label = if named { power_of_ten(digit, decade) } else { String::new() };
                ticks.push(Tick { value: f64::from(digit) * 10f64.powi(decade as i32), label });
            }
        }
        ticks
    }
}

fn coordinate(scale: Scale, value: f64) -> Option<f64> {
    let at = match scale {
        Scale::Linear => value,
        Scale::Log if value > 0.0 => value.log10(),
        Scale::Log => return None,
    };
    at.is_finite().then_some(at)
}

/// digit · 10^decade: in full from 0.01 to 10000, else with an exponent.
fn power_of_ten(digit: i32, decade: i64) -> String {
    match decade {
        -2..=-1 => format!("{:.*}", -decade as usize, f64::from(digit) * 10f64.powi(decade as i32)),
        0..=4 => format!("{}", i64::from(digit) * 10i64.pow(decade as u32)),
        _ if digit == 1 => format!("10{}", superscript(decade)),
        _ => format!("{digit}·10{}", superscript(decade)),
    }
}

/// An integer in raised digits.
fn superscript(number: i64) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
    number.to_string().chars().map(raise).collect()
}
