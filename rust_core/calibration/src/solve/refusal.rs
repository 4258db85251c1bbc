//! Why samples are refused: what is wrong, and what to do.

use super::Parameter;

/// A calibration that is not to be had from these samples. Nothing wrong is averaged away.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A coordinate or a deviation is NaN or infinite.
    #[error("sample {sample} is not finite: drop such rows before solving")]
    NotFinite {
        /// Its index.
        sample: usize,
    },
    /// A standard deviation is negative.
    #[error("sample {sample} has a negative standard deviation: give positive ones, or 0 if it is not known")]
    NegativeDeviation {
        /// Its index.
        sample: usize,
    },
    /// A point that no camera sees.
    #[error("sample {sample} lies behind the camera: points must be in the camera's optical frame, z along the view")]
    BehindCamera {
        /// Its index.
        sample: usize,
    },
    /// Pixels beside the picture.
    #[error(
        "{outside} of {points} samples lie outside of {}x{} pixels, such as ({:.1}, {:.1}): these are data of a \
         projector of another size, give its own",
        size_px[0], size_px[1], example[0], example[1]
    )]
    OtherSize {
        /// How many lie beside the picture.
        outside: usize,
        /// How many samples there are.
        points: usize,
        /// The size that was given.
        size_px: [u32; 2],
        /// One of the pixels.
        example: [f64; 2],
    },
    /// Distances that no depth camera measures.
    #[error("the points are {typical_m:.0} m away, in the middle: give coordinates in metres (are they millimetres?)")]
    NotMetres {
        /// The median depth.
        typical_m: f64,
    },
    /// A given lens belongs to another picture.
    #[error(
        "the given lens is for {}x{} pixels, the projector has {}x{}: calibrate the lens for this size",
        lens_px[0], lens_px[1], size_px[0], size_px[1]
    )]
    OtherLens {
        /// The lens's size.
        lens_px: [u32; 2],
        /// The projector's size.
        size_px: [u32; 2],
    },
    /// Fewer samples than a solution needs that can be judged.
    #[error(
        "{points} samples in scan {scan} are too few, at least {needed} are needed: scan a larger part of the scene"
    )]
    TooFew {
        /// Samples.
        points: usize,
        /// How many it takes.
        needed: usize,
        /// The scan that has too few.
        scan: u32,
    },
    /// A plane does not determine a lens.
    #[error(
        "the scene is flat, which does not determine the lens: put things at different depths before the wall; a pose \
         alone is possible with a known lens (refine)"
    )]
    Flat,
    /// The samples lie too close to each other.
    #[error(
        "the points cover {picture_percent:.0} % of the picture, too little to determine the lens: move the camera \
         back or light more of the scene; a pose alone is possible with a known lens (refine)"
    )]
    BadlySpread {
        /// The share of the picture within the points' outline, percent.
        picture_percent: f64,
    },
    /// The samples agree with very different lenses or poses.
    #[error(
        "the points do not determine the result: {what} is uncertain by {sigma:.3} {unit}; scan things at more \
         different depths over more of the picture, or fix what is known"
    )]
    Undetermined {
        /// What is uncertain.
        what: &'static str,
        /// Its standard deviation.
        sigma: f64,
        /// The unit of `sigma`.
        unit: &'static str,
    },
    /// The picture is that of a mirror.
    #[error(
        "the projector's pixels are mirrored (left to right or upside down): switch off the projector's rear or \
         ceiling flip, and check that the pictures are shown as they are"
    )]
    Mirrored,
    /// The light would have to go backwards.
    #[error(
        "{percent:.0} % of the points lie behind the projector, where it cannot light them: check that points and \
         pixels belong together and the units are metres"
    )]
    BehindProjector {
        /// Their share.
        percent: f64,
    },
    /// A focal length that no lens has.
    #[error("the focal length {0} of {1} is not positive: give positive ones, the picture must not be mirrored")]
    NegativeFocal(f64, Parameter),
    /// A lens that is given has a skew, which the solver's lenses have not.
    #[error("the lens that is given has a skew (K[1] {} and K[3] {}): give one without", skew_px[0], skew_px[1])]
    Skewed {
        /// `K[1]` and `K[3]`.
        skew_px: [f64; 2],
    },
    /// A given value is no number.
    #[error("the value given for {0} is not a finite number: leave it out or give a number")]
    FixedNotFinite(Parameter),
    /// Two given values cannot both hold.
    #[error("different values are given for {0} and {1}, which have to be equal: give one of them")]
    Contradiction(Parameter, Parameter),
    /// Most samples do not fit.
    #[error(
        "only {percent:.0} % of the samples of scan {scan} agree with each other: the camera, the projector or the \
         things moved, or the decoding failed; scan again with everything at rest and keystone correction off"
    )]
    FewInliers {
        /// The share that agrees.
        percent: f64,
        /// The scan.
        scan: u32,
    },
    /// Two poses in one scan.
    #[error(
        "the camera moved during scan {scan}: {first_percent:.0} % of the samples agree with one pose and \
         {second_percent:.0} % with another; scan again with everything at rest and keystone correction off"
    )]
    Moved {
        /// The scan.
        scan: u32,
        /// The share that agrees with the first pose.
        first_percent: f64,
        /// The share that agrees with the second.
        second_percent: f64,
    },
    /// Two poses in one scan that are close to each other.
    #[error(
        "{second_percent:.0} % of the samples of scan {scan}, {}, land {apart_px:.1} px beside the others: the camera, \
         the things or the projector's zoom moved; scan again with everything at rest, or number the camera's poses in \
         the column scan",
        if *is_in_order { "the last ones" } else { "among the others" }
    )]
    TwoPoses {
        /// The scan.
        scan: u32,
        /// How far apart the light of both poses is, root of the mean square, pixels.
        apart_px: f64,
        /// The share of the samples that were seen from the second pose.
        second_percent: f64,
        /// Whether these come after the others.
        is_in_order: bool,
    },
    /// A distortion that was not to be solved for.
    #[error(
        "the lens has a distortion that is not solved for, without which {percent:.0} % of the samples do not fit: \
         solve for all of its terms, and fix none"
    )]
    DistortionLeftOut {
        /// The share of the samples that fits with all terms only.
        percent: f64,
    },
    /// Nothing fits.
    #[error(
        "no lens and pose fit the samples of scan {scan}: check that pixels and points belong together, scan again"
    )]
    NoSolution {
        /// The scan.
        scan: u32,
    },
    /// All fit, but badly.
    #[error(
        "the samples miss the best solution by {typical_px:.1} px: the camera moved, the depth is not registered to \
         the image, or the given lens is another's; scan again with everything at rest and keystone correction off"
    )]
    Inconsistent {
        /// The typical miss.
        typical_px: f64,
    },
    /// The fit is better than what it predicts.
    #[error(
        "the solution fits its points within {rms_px:.2} px but misses left-out ones by {held_out_px:.2} px, so it is \
         not to be trusted: scan more points over more of the picture and at more depths"
    )]
    Unpredictive {
        /// Root mean square of the points that were used.
        rms_px: f64,
        /// The same of points that were left out.
        held_out_px: f64,
    },
}
