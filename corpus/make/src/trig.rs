//! Sine and cosine from `+` and `×` alone: a platform's own differ in the last bit, and these do not.

use std::f64::consts::TAU;

/// The sine of an angle given in turns.
pub fn sin(turns: f64) -> f64 {
    // Reduced to the quarter turn around 0, where the series below is exact to the last bits.
    let t = turns - (turns + 0.5).floor();
    let t = if t > 0.25 {
        0.5 - t
    } else if t < -0.25 {
        -0.5 - t
    } else {
        t
    };
    let x = TAU * t;
    let xx = x * x;
    // The Taylor series up to x^21, by Horner's rule.
    let mut sum = 1.0;
    for k in (1..=10).rev() {
        let k = f64::from(2 * k);
        sum = 1.0 - xx / (k * (k + 1.0)) * sum;
    }
    x * sum
}

/// The cosine of an angle given in turns.
pub fn cos(turns: f64) -> f64 {
    sin(turns + 0.25)
}

#[cfg(test)]
mod tests {
    #[test]
    fn sine_and_cosine_agree_with_the_platform() {
        for i in -500..500 {
            let turns = f64::from(i) / 137.0;
            assert!((super::sin(turns) - (turns * std::f64::consts::TAU).sin()).abs() < 1e-13, "sin {turns}");
            assert!((super::cos(turns) - (turns * std::f64::consts::TAU).cos()).abs() < 1e-13, "cos {turns}");
        }
    }
}
