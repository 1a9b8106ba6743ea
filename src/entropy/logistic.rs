//! Probabilities and their log-odds, in integers: the tables `stretch` and `squash`.
//!
//! Log-odds are held in 256ths, clamped to ±[`LIMIT`]; probabilities in 65536ths. The tables are
//! computed when the crate is compiled, from + − × ÷ on `f64` alone, so they are the same everywhere.

/// The largest log-odds, in 256ths: 12, beyond which 16-bit probabilities end.
pub(super) const LIMIT: i32 = 12 * 256 - 1;

/// Probabilities (in 65536ths) of log-odds −LIMIT ..= LIMIT.
static SQUASH: [u16; 2 * LIMIT as usize + 1] = squash_table();

/// Log-odds of probabilities (in 4096ths, at the middle of each).
static STRETCH: [i16; 4096] = stretch_table();

/// The probability, in 65536ths, of these log-odds; 1 ..= 65535.
#[inline]
pub(super) fn squash(log_odds: i32) -> u32 {
    SQUASH[(log_odds.clamp(-LIMIT, LIMIT) + LIMIT) as usize].into()
}

/// The log-odds of a probability in 65536ths.
#[inline]
pub(super) fn stretch(p: u32) -> i32 {
    STRETCH[(p >> 4 & 4095) as usize].into()
}

/// eˣ for |x| ≤ 16: the series of x/1024, squared ten times.
const fn exp(x: f64) -> f64 {
    let y = x / 1024.0;
    let mut e = 1.0 + y * (1.0 + y / 2.0 * (1.0 + y / 3.0 * (1.0 + y / 4.0 * (1.0 + y / 5.0))));
    let mut i = 0;
    while i < 10 {
        e *= e;
        i += 1;
    }
    e
}

/// ln x for x > 0, by Newton's method on eˣ.
const fn ln(x: f64) -> f64 {
    let mut y = 0.0;
    let mut i = 0;
    while i < 40 {
        let e = exp(y);
        y += 2.0 * (x - e) / (x + e);
        i += 1;
    }
    y
}

const fn squash_table() -> [u16; 2 * LIMIT as usize + 1] {
    let mut table = [0; 2 * LIMIT as usize + 1];
    let mut i = 0;
    while i < table.len() {
        let p = 65536.0 / (1.0 + exp(-((i as i32 - LIMIT) as f64) / 256.0)) + 0.5;
        table[i] = if p < 1.0 {
            1
        } else if p >= 65535.0 {
            65535
        } else {
            p as u16
        };
        i += 1;
    }
    table
}

const fn stretch_table() -> [i16; 4096] {
    let mut table = [0; 4096];
    let mut i = 0;
    while i < 4096 {
        let p = (i as f64 + 0.5) / 4096.0;
        let x = 256.0 * ln(p / (1.0 - p));
        table[i] = if x < 0.0 { (x - 0.5) as i16 } else { (x + 0.5) as i16 };
        i += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_the_logistic_function_and_its_inverse() {
        for x in -LIMIT..=LIMIT {
            let exact = 65536.0 / (1.0 + (-f64::from(x) / 256.0).exp());
            assert!((f64::from(squash(x)) - exact.clamp(1.0, 65535.0)).abs() <= 0.51, "squash({x})");
        }
        for i in 0..4096_u32 {
            let p = (f64::from(i) + 0.5) / 4096.0;
            let exact = 256.0 * (p / (1.0 - p)).ln();
            assert!((f64::from(stretch(i << 4)) - exact).abs() <= 0.51, "stretch({i})");
        }
    }

    #[test]
    fn the_tables_are_those_of_the_specification() {
        let made: String = std::iter::once("squash\n".to_owned())
            .chain(SQUASH.iter().map(|p| format!("{p}\n")))
            .chain(std::iter::once("stretch\n".to_owned()))
            .chain(STRETCH.iter().map(|x| format!("{x}\n")))
            .collect();
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("spec/vectors/logistic.txt");
        if std::env::var_os("GIMC_BLESS").is_some() {
            std::fs::write(&path, &made).unwrap();
        }
        assert!(std::fs::read_to_string(path).unwrap() == made, "see spec/README.md, \"Changes\"");
    }
}
