//! Functions that are bit for bit the same on every machine: + − × ÷ √ and the bits of an `f64`, nothing else.
//!
//! A platform's own `exp` and `ln` may differ in the last bit, and one bit is enough to lose a stream.

const LN_2: f64 = std::f64::consts::LN_2;

/// eˣ within 1e−13 of itself; x is clamped to ±700.
#[inline]
pub(super) fn exp(x: f64) -> f64 {
    let x = x.clamp(-700.0, 700.0);
    let k = (x / LN_2 + 0.5).floor();
    // |r| ≤ ln 2 / 2; the series to r¹¹ / 11!.
    let r = x - k * LN_2;
    let mut e = 1.0;
    for n in (1..=11).rev() {
        e = 1.0 + e * r / f64::from(n);
    }
    e * f64::from_bits(((k as i64 + 1023) as u64) << 52)
}

/// ln x within 1e−13; x must be positive and normal (smaller values count as the smallest normal).
#[inline]
pub(super) fn ln(x: f64) -> f64 {
    let bits = x.max(f64::MIN_POSITIVE).to_bits();
    let mut k = (bits >> 52) as i64 - 1023;
    let mut m = f64::from_bits(bits & ((1 << 52) - 1) | 1023 << 52);
    if m > std::f64::consts::SQRT_2 {
        m *= 0.5;
        k += 1;
    }
    // ln m = 2 artanh t, t = (m − 1) / (m + 1), |t| ≤ 0.172; the series to t¹⁵ / 15.
    let t = (m - 1.0) / (m + 1.0);
    let t2 = t * t;
    let series = [1.0 / 15.0, 1.0 / 13.0, 1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0, 1.0];
    k as f64 * LN_2 + 2.0 * t * series.into_iter().fold(0.0, |sum, c| sum * t2 + c)
}

/// arccos x within 7e−5 (M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 4.4.45).
#[inline]
pub(super) fn acos(x: f64) -> f64 {
    let a = x.abs().min(1.0);
    let near = (1.0 - a).sqrt() * (1.570_728_8 + a * (-0.212_114_4 + a * (0.074_261_0 - a * 0.018_729_3)));
    if x < 0.0 { std::f64::consts::PI - near } else { near }
}

/// cot x for 0 < x < π, within 1e−7 · (1 + |cot x|).
#[inline]
pub(super) fn cot(x: f64) -> f64 {
    // Mirrored to (0, π/2], halved twice to (0, π/8], where the series of the cotangent is short:
    // cot y = 1/y − y/3 − y³/45 − 2y⁵/945 − …; then cot 2y = (cot y − 1 / cot y) / 2.
    let mirrored = x > std::f64::consts::FRAC_PI_2;
    let y = (if mirrored { std::f64::consts::PI - x } else { x }).max(1e-3) / 4.0;
    let y2 = y * y;
    let mut c = 1.0 / y - y * (1.0 / 3.0 + y2 * (1.0 / 45.0 + y2 * (2.0 / 945.0 + y2 / 4725.0)));
    for _ in 0..2 {
        c = (c - 1.0 / c) / 2.0;
    }
    if mirrored { -c } else { c }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_what_their_names_say() {
        for i in -7000..=7000 {
            let x = f64::from(i) / 10.0;
            assert!((exp(x) / x.exp() - 1.0).abs() < 1e-12, "exp({x})");
            let y = 1.013_f64.powi(i);
            assert!((ln(y) - y.ln()).abs() < 1e-12, "ln({y})");
        }
        for i in -1000..=1000 {
            let x = f64::from(i) / 1000.0;
            assert!((acos(x) - x.acos()).abs() < 7e-5, "acos({x})");
        }
        for i in 1..314 {
            let x = f64::from(i) / 100.0;
            assert!((cot(x) - 1.0 / x.tan()).abs() < 1e-7 * (1.0 + cot(x).abs()), "cot({x}) = {}", cot(x));
        }
    }
}
