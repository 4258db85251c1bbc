//! Lens distortion as a CameraInfo describes it: a model's name, and so many coefficients as the model has.
//!
//! The names are those of `sensor_msgs/distortion_models.h`; the numbers of coefficients are those that OpenCV's
//! functions take, which image_geometry hands them to.

use std::fmt;

/// How a lens deviates from a pinhole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DistortionModel {
    /// Brown and Conrady's: k1, k2, p1, p2 and, mostly, k3.
    PlumbBob,
    /// Radial distortion as a quotient of two polynomials: k1, k2, p1, p2, k3 to k6; then, if there are 12, the thin
    /// prism's s1 to s4, and with 14 the tilt of the sensor.
    RationalPolynomial,
    /// Kannala and Brandt's, for fisheye lenses: k1 to k4.
    Equidistant,
}

impl DistortionModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::PlumbBob, Self::RationalPolynomial, Self::Equidistant];

    /// The name in a CameraInfo.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PlumbBob => "plumb_bob",
            Self::RationalPolynomial => "rational_polynomial",
            Self::Equidistant => "equidistant",
        }
    }

    /// The model of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }

    /// The numbers of coefficients that it can have.
    pub const fn coefficient_counts(self) -> &'static [usize] {
        match self {
            Self::PlumbBob => &[4, 5],
            Self::RationalPolynomial => &[8, 12, 14],
            Self::Equidistant => &[4],
        }
    }
}

impl fmt::Display for DistortionModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What is wrong with the distortion of a CameraInfo.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DistortionProblem {
    /// The model is none of those that ROS's packages know.
    #[error("'{0}' is not known (plumb_bob, rational_polynomial, equidistant)")]
    UnknownModel(String),
    /// The model has another number of coefficients.
    #[error("{count} coefficients, but {model} has {}", any_of(.model.coefficient_counts()))]
    Coefficients {
        /// The model.
        model: DistortionModel,
        /// How many coefficients there are.
        count: usize,
    },
}

impl DistortionProblem {
    /// The key of the file that has the problem.
    pub fn key(&self) -> &'static str {
        match self {
            Self::UnknownModel(_) => "distortion_model",
            Self::Coefficients { .. } => "D",
        }
    }
}

fn any_of(counts: &[usize]) -> String {
    counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ")
}

/// Checks the model and the number of coefficients. If all of them are zero, or there are none, there is no distortion
/// and nothing to check.
///
/// # Errors
/// [`DistortionProblem`].
pub(super) fn check(model: &str, coefficients: &[f64]) -> Result<(), DistortionProblem> {
    if coefficients.iter().all(|coefficient| *coefficient == 0.0) {
        return Ok(());
    }
    let model = DistortionModel::from_name(model).ok_or_else(|| DistortionProblem::UnknownModel(model.to_owned()))?;
    let count = coefficients.len();
    if model.coefficient_counts().contains(&count) {
        Ok(())
    } else {
        Err(DistortionProblem::Coefficients { model, count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_have_their_numbers_of_coefficients() {
        for model in DistortionModel::ALL {
            assert_eq!(DistortionModel::from_name(model.name()), Some(model));
            for count in 1..16 {
                let is_fine = check(model.name(), &vec![0.1; count]).is_ok();
                assert_eq!(is_fine, model.coefficient_counts().contains(&count), "{model} {count}");
                assert_eq!(check(model.name(), &vec![0.0; count]), Ok(()), "no distortion");
            }
            assert_eq!(check(model.name(), &[]), Ok(()));
        }
    }

    #[test]
    fn problems_name_model_and_numbers() {
        let problem = check("plumb_bob", &[0.1; 8]).unwrap_err();
        assert_eq!(problem.to_string(), "8 coefficients, but plumb_bob has 4 or 5");
        let problem = check("fov", &[0.1]).unwrap_err();
        assert!(problem.to_string().contains("'fov'"), "{problem}");
        assert_eq!(check("none", &[0.0; 5]), Ok(()));
    }
}
