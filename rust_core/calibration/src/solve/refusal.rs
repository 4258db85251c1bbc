//! Refused samples: reasons, with advice.

use super::Parameter;

/// Reason why samples do not allow a calibration. Nothing wrong is averaged away.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A coordinate or a deviation of a sample, by its index, is NaN or infinite.
    #[error("sample {0} is not finite: drop such rows before solving")]
    NotFinite(usize),
    /// A standard deviation of a sample, by its index, is negative.
    #[error("sample {0} has a negative standard deviation: give positive ones, or 0 if it is not known")]
    NegativeDeviation(usize),
    /// A sample, by its index, lies behind the camera.
    #[error("sample {0} lies behind the camera: points must be in the camera's optical frame, z along the view")]
    BehindCamera(usize),
    /// Pixels lie outside of the image.
    #[error(
        "{outside} of {points} samples lie outside of {}x{} pixels, such as ({:.1}, {:.1}): these are data of a \
         projector of another size, give its own",
        size_px[0], size_px[1], example[0], example[1]
    )]
    OtherSize {
        /// Number of samples outside of the image.
        outside: usize,
        /// Number of samples.
        points: usize,
        /// Given image size.
        size_px: [u32; 2],
        /// Example of such a pixel.
        example: [f64; 2],
    },
    /// The median depth, metres, exceeds the range of depth cameras.
    #[error("the median depth is {0:.0} m: give coordinates in metres (are they millimetres?)")]
    NotMetres(f64),
    /// A given lens has another image size.
    #[error(
        "the given lens is for {}x{} pixels, the projector has {}x{}: calibrate the lens for this size",
        lens_px[0], lens_px[1], size_px[0], size_px[1]
    )]
    OtherLens {
        /// Image size of the lens.
        lens_px: [u32; 2],
        /// Image size of the projector.
        size_px: [u32; 2],
    },
    /// Too few samples.
    #[error(
        "{points} samples in scan {scan} are too few, at least {needed} are needed: scan a larger part of the scene"
    )]
    TooFew {
        /// Number of samples.
        points: usize,
        /// Required number.
        needed: usize,
        /// Number of the scan.
        scan: u32,
    },
    /// The scene is a plane, which does not determine a lens.
    #[error(
        "the scene is flat, which does not determine the lens: put objects at different depths before the wall; a pose \
         alone is possible with a known lens (refine)"
    )]
    Flat,
    /// The convex hull of the points covers too little of the image, percent.
    #[error(
        "the points cover {0:.0} % of the picture, too little to determine the lens: move the camera \
         back or light more of the scene; a pose alone is possible with a known lens (refine)"
    )]
    BadlySpread(f64),
    /// The samples leave the result too uncertain.
    #[error(
        "the points do not determine the result: {what} is uncertain by {sigma:.3} {unit}; scan objects at more \
         different depths over more of the picture, or fix what is known"
    )]
    Undetermined {
        /// Uncertain quantity.
        what: &'static str,
        /// Standard deviation.
        sigma: f64,
        /// Unit of `sigma`.
        unit: &'static str,
    },
    /// The image is mirrored.
    #[error(
        "the projector's pixels are mirrored (left to right or upside down): switch off the projector's rear or \
         ceiling flip, and check that the pictures are shown as they are"
    )]
    Mirrored,
    /// A share of the points, percent, lies behind the projector.
    #[error(
        "{0:.0} % of the points lie behind the projector, where it cannot light them: check that points and \
         pixels belong together and the units are metres"
    )]
    BehindProjector(f64),
    /// A given focal length is not positive.
    #[error("the focal length {0} of {1} is not positive: give positive ones, the picture must not be mirrored")]
    NegativeFocal(f64, Parameter),
    /// A given lens has a skew, which the solver does not support.
    #[error("the lens that is given has a skew (K[1] {} and K[3] {}): give one without", skew_px[0], skew_px[1])]
    Skewed {
        /// `K[1]` and `K[3]`.
        skew_px: [f64; 2],
    },
    /// A given value is not finite.
    #[error("the value given for {0} is not a finite number: leave it out or give a number")]
    FixedNotFinite(Parameter),
    /// Two given values contradict each other.
    #[error("different values are given for {0} and {1}, which have to be equal: give one of them")]
    Contradiction(Parameter, Parameter),
    /// Too few inliers.
    #[error(
        "only {percent:.0} % of the samples of scan {scan} agree with each other: the camera, the projector or an \
         object moved, or the decoding failed; scan again with everything at rest and keystone correction off"
    )]
    FewInliers {
        /// Share of inliers, percent.
        percent: f64,
        /// Number of the scan.
        scan: u32,
    },
    /// A scan has two poses.
    #[error(
        "the camera moved during scan {scan}: {first_percent:.0} % of the samples agree with one pose and \
         {second_percent:.0} % with another; scan again with everything at rest and keystone correction off"
    )]
    Moved {
        /// Number of the scan.
        scan: u32,
        /// Share that agrees with the first pose, percent.
        first_percent: f64,
        /// Share that agrees with the second pose, percent.
        second_percent: f64,
    },
    /// A scan has two poses that are close to each other.
    #[error(
        "{second_percent:.0} % of the samples of scan {scan}, {}, are {apart_px:.1} px off the others: the camera, an \
         object or the projector's zoom moved; scan again with everything at rest, or number the camera's poses in the \
         column scan",
        if *is_in_order { "the last ones" } else { "among the others" }
    )]
    TwoPoses {
        /// Number of the scan.
        scan: u32,
        /// RMS distance of both poses' predictions, pixels.
        apart_px: f64,
        /// Share of the second pose's samples, percent.
        second_percent: f64,
        /// `true` if these come after the others.
        is_in_order: bool,
    },
    /// A share of the samples, percent, fits only with distortion terms that are not solved for.
    #[error(
        "the lens has a distortion that is not solved for, without which {0:.0} % of the samples do not fit: \
         solve for all of its terms, and fix none"
    )]
    DistortionLeftOut(f64),
    /// No lens and pose fit a scan, by its number.
    #[error("no lens and pose fit the samples of scan {0}: check that pixels and points belong together, scan again")]
    NoSolution(u32),
    /// The RMS error, pixels, is too large.
    #[error(
        "the RMS error of the best solution is {0:.1} px: the camera moved, the depth is not registered to the \
         image, or the given lens is another's; scan again with everything at rest and keystone correction off"
    )]
    Inconsistent(f64),
    /// The solution is overfitted.
    #[error(
       "the RMS error is {rms_px:.2} px, but {held_out_px:.2} px for held-out points, so the solution is unreliable: scan \
        more points over more of the picture and at more depths"
    )]
    Unpredictive {
        /// RMS error of the used points, pixels.
        rms_px: f64,
        /// Held-out RMS error, pixels.
        held_out_px: f64,
    },
}
