//! Vertices that slide: coded as places on a lattice of their own ([`Frame`]) and not as coordinates.
//!
//! What there is to say of the three places is what is said of coordinates, measured in the steps of that lattice: its centre
//! is what is expected, and its axes are those of the error, so that no axis tells anything of the next.

use super::contexts::{Landmarks, Moment};
use super::frame::{Frame, PARTS};
use super::vector::Vector;
use super::window::Window;
use super::{Coder, Forecast};
use crate::entropy::BitCoder;

/// No place is farther from the centre, in a box of this extent: the finest step is an eighth, and the diagonal of the box is
/// shorter than twice its longest side.
pub(super) fn farthest(extent: [i32; 3]) -> i64 {
    i64::from(extent.into_iter().max().unwrap_or(0)) + 16
}

impl<const F: usize, const L: usize, const N: usize, const E: usize> Coder<'_, F, L, N, E> {
    /// The point of the box that is nearest to a prediction, whatever that is.
    pub(super) fn in_box(&self, point: Vector) -> Vector {
        // `max` takes what is no number to 0.
        Vector([0, 1, 2].map(|i| point[i].max(0.0).min(f64::from(self.extent[i]) / PARTS)))
    }

    /// The standard deviations to expect on the axes of the frame.
    pub(super) fn deviations(forecast: &Forecast, frame: &Frame) -> [f64; 3] {
        let [across, along] = forecast.scale;
        if forecast.view.is_none() {
            return [(0.55 * across * across).sqrt().max(0.2); 3];
        }
        let across = across / frame.steps[0];
        let along = along / frame.steps[2];
        let tangential = (0.55 * across * across).max(0.01).sqrt();
        [tangential, tangential, (1.2 * along * along + 0.02).sqrt()]
    }

    /// Codes the three places, the one along the normal last.
    pub(super) fn places<C: BitCoder>(
        &mut self,
        coder: &mut C,
        forecast: &Forecast,
        frame: &Frame,
        wanted: [i64; 3],
    ) -> Option<[i64; 3]> {
        let deviations = Self::deviations(forecast, frame);
        let landmarks = Landmarks::new(&self.scene, &self.ring);
        let mut places = [0; 3];
        let mut surprise = 0.0_f64;
        for axis in 0..3 {
            let window = Window::all(&self.values[axis]);
            let [base, by_valence] = [1, 2].map(|m| frame.coordinate(forecast.means[m], axis));
            let moment = Moment {
                base,
                frame: Some(frame),
                landmarks: &landmarks,
                window,
                axis,
                rank: axis,
                centre: 0,
                means: [0.0, base, by_valence],
                deviation: deviations[axis],
                surprise,
                last: self.last,
                last_of_axis: self.last_of_axis[axis],
            };
            let index = self.coordinates.code(coder, wanted[axis], 0, window, &moment.densities(), moment.contexts(), axis);
            places[axis] = i64::from(window.value(index)?);
            let z = places[axis].abs() as f64 / deviations[axis].max(0.3);
            surprise = if axis == 0 { z } else { z.max(0.7 * surprise) };
            self.last = [index, self.last[0]];
            self.last_of_axis[axis] = index;
        }
        Some(places)
    }
}
