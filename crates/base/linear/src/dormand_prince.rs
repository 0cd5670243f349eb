//! Runge-Kutta method of order eight by Dormand and Prince, with Hairer's error estimate (E. Hairer, S. P. Nørsett, G. Wanner: Solving Ordinary
//! Differential Equations I, 2nd ed. 1993, section II.10: the code DOP853).

/// Nodes of the method: fractions of a step at which inputs are needed.
pub const DORMAND_PRINCE_NODES: [f64; 12] = [
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    0.3333333333333333,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
];

/// Nodes of [`DormandPrinceDense`].
pub const DORMAND_PRINCE_DENSE_NODES: [f64; 16] = {
    let mut nodes = [0.0; 16];
    let mut place = 0;
    while place < 12 {
        nodes[place] = DORMAND_PRINCE_NODES[place];
        place += 1;
    }
    nodes[12] = 1.0;
    nodes[13] = 0.1;
    nodes[14] = 0.2;
    nodes[15] = 7.0 / 9.0;
    nodes
};

/// Coefficients of each stage: indices and weights of earlier slopes. The last row gives the result.
const STAGES: [&[(usize, f64)]; 13] = [
    &[],
    &[(0, 0.05260015195876773)],
    &[(0, 0.0197250569845379), (1, 0.0591751709536137)],
    &[(0, 0.02958758547680685), (2, 0.08876275643042054)],
    &[
        (0, 0.2413651341592667),
        (2, -0.8845494793282861),
        (3, 0.924834003261792),
    ],
    &[
        (0, 0.037037037037037035),
        (3, 0.17082860872947386),
        (4, 0.12546768756682242),
    ],
    &[
        (0, 0.037109375),
        (3, 0.17025221101954405),
        (4, 0.06021653898045596),
        (5, -0.017578125),
    ],
    &[
        (0, 0.03709200011850479),
        (3, 0.17038392571223998),
        (4, 0.10726203044637328),
        (5, -0.015319437748624402),
        (6, 0.008273789163814023),
    ],
    &[
        (0, 0.6241109587160757),
        (3, -3.3608926294469414),
        (4, -0.868219346841726),
        (5, 27.59209969944671),
        (6, 20.154067550477894),
        (7, -43.48988418106996),
    ],
    &[
        (0, 0.47766253643826434),
        (3, -2.4881146199716677),
        (4, -0.590290826836843),
        (5, 21.230051448181193),
        (6, 15.279233632882423),
        (7, -33.28821096898486),
        (8, -0.020331201708508627),
    ],
    &[
        (0, -0.9371424300859873),
        (3, 5.186372428844064),
        (4, 1.0914373489967295),
        (5, -8.149787010746927),
        (6, -18.52006565999696),
        (7, 22.739487099350505),
        (8, 2.4936055526796523),
        (9, -3.0467644718982196),
    ],
    &[
        (0, 2.273310147516538),
        (3, -10.53449546673725),
        (4, -2.0008720582248625),
        (5, -17.9589318631188),
        (6, 27.94888452941996),
        (7, -2.8589982771350235),
        (8, -8.87285693353063),
        (9, 12.360567175794303),
        (10, 0.6433927460157636),
    ],
    &[
        (0, 0.054293734116568765),
        (5, 4.450312892752409),
        (6, 1.8915178993145003),
        (7, -5.801203960010585),
        (8, 0.3111643669578199),
        (9, -0.1521609496625161),
        (10, 0.20136540080403034),
        (11, 0.04471061572777259),
    ],
];

/// Weights of the result's difference from the embedded methods of order five and three.
const ERROR_OF_FIFTH: &[(usize, f64)] = &[
    (0, 0.01312004499419488),
    (5, -1.2251564463762044),
    (6, -0.4957589496572502),
    (7, 1.6643771824549864),
    (8, -0.35032884874997366),
    (9, 0.3341791187130175),
    (10, 0.08192320648511571),
    (11, -0.022355307863886294),
];
const ERROR_OF_THIRD: &[(usize, f64)] = &[
    (0, -0.18980075407240762),
    (5, 4.450312892752409),
    (6, 1.8915178993145003),
    (7, -5.801203960010585),
    (8, -0.4226823213237919),
    (9, -0.1521609496625161),
    (10, 0.20136540080403034),
    (11, 0.02265179219836082),
];

/// Coefficients of the three additional stages of the interpolating polynomial.
const DENSE_STAGES: [&[(usize, f64)]; 3] = [
    &[
        (0, 0.056167502283047954),
        (6, 0.25350021021662483),
        (7, -0.2462390374708025),
        (8, -0.12419142326381637),
        (9, 0.15329179827876568),
        (10, 0.00820105229563469),
        (11, 0.007567897660545699),
        (12, -0.008298),
    ],
    &[
        (0, 0.03183464816350214),
        (5, 0.028300909672366776),
        (6, 0.053541988307438566),
        (7, -0.05492374857139099),
        (10, -0.00010834732869724932),
        (11, 0.0003825710908356584),
        (12, -0.00034046500868740456),
        (13, 0.1413124436746325),
    ],
    &[
        (0, -0.42889630158379194),
        (5, -4.697621415361164),
        (6, 7.683421196062599),
        (7, 4.06898981839711),
        (8, 0.3567271874552811),
        (12, -0.0013990241651590145),
        (13, 2.9475147891527724),
        (14, -9.15095847217987),
    ],
];

/// Weights of the slopes in the last four terms of that polynomial.
const DENSE_TERMS: [&[(usize, f64)]; 4] = [
    &[
        (0, -8.428938276109013),
        (5, 0.5667149535193777),
        (6, -3.0689499459498917),
        (7, 2.38466765651207),
        (8, 2.117034582445028),
        (9, -0.871391583777973),
        (10, 2.2404374302607883),
        (11, 0.6315787787694688),
        (12, -0.08899033645133331),
        (13, 18.148505520854727),
        (14, -9.194632392478356),
        (15, -4.436036387594894),
    ],
    &[
        (0, 10.427508642579134),
        (5, 242.28349177525817),
        (6, 165.20045171727028),
        (7, -374.5467547226902),
        (8, -22.113666853125306),
        (9, 7.733432668472264),
        (10, -30.674084731089398),
        (11, -9.332130526430229),
        (12, 15.697238121770845),
        (13, -31.139403219565178),
        (14, -9.35292435884448),
        (15, 35.81684148639408),
    ],
    &[
        (0, 19.985053242002433),
        (5, -387.0373087493518),
        (6, -189.17813819516758),
        (7, 527.8081592054236),
        (8, -11.57390253995963),
        (9, 6.8812326946963),
        (10, -1.0006050966910838),
        (11, 0.7777137798053443),
        (12, -2.778205752353508),
        (13, -60.19669523126412),
        (14, 84.32040550667716),
        (15, 11.99229113618279),
    ],
    &[
        (0, -25.69393346270375),
        (5, -154.18974869023643),
        (6, -231.5293791760455),
        (7, 357.6391179106141),
        (8, 93.40532418362432),
        (9, -37.45832313645163),
        (10, 104.0996495089623),
        (11, 29.8402934266605),
        (12, -43.53345659001114),
        (13, 96.32455395918828),
        (14, -39.17726167561544),
        (15, -149.72683625798564),
    ],
];

/// One step of length `h` of `y' = f(s, y)`, with the estimate of its error. `s`: further inputs of `f` at the [`DORMAND_PRINCE_NODES`].
#[inline(always)]
pub fn dormand_prince_step<S, const N: usize>(
    y: &[f64; N],
    h: f64,
    inputs: &[S; 12],
    f: impl Fn(&S, &[f64; N]) -> [f64; N],
) -> ([f64; N], [f64; N]) {
    let mut slopes = [[0.0; N]; 12];
    // A loop with one call of `f`, so that the compiler inlines it.
    for ((stage, weights), inputs) in STAGES.iter().enumerate().zip(inputs) {
        let mut at = *y;
        add(&mut at, h, weights, &slopes);
        slopes[stage] = f(inputs, &at);
    }
    let mut after = *y;
    add(&mut after, h, STAGES[12], &slopes);
    (after, estimate(h, &slopes))
}

/// The estimate of a step's error.
#[inline(always)]
fn estimate<const N: usize, const STAGES: usize>(h: f64, slopes: &[[f64; N]; STAGES]) -> [f64; N] {
    let (mut error, mut third) = ([0.0; N], [0.0; N]);
    add(&mut error, h, ERROR_OF_FIFTH, slopes);
    add(&mut third, h, ERROR_OF_THIRD, slopes);
    for (fifth, third) in error.iter_mut().zip(third) {
        let both = (*fifth * *fifth + 0.01 * third * third).sqrt();
        if both > 0.0 {
            *fifth *= fifth.abs() / both;
        }
    }
    error
}

/// A step as in [`dormand_prince_step`], with the interpolating polynomial of degree seven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DormandPrinceDense<const N: usize> {
    /// State at the end of the step.
    pub after: [f64; N],
    /// Estimate of its error.
    pub error: [f64; N],
    begin: [f64; N],
    terms: [[f64; N]; 7],
}

impl<const N: usize> DormandPrinceDense<N> {
    /// A step of length `h` from `y`; inputs of `f` at the [`DORMAND_PRINCE_DENSE_NODES`].
    pub fn new<S>(
        y: &[f64; N],
        h: f64,
        inputs: &[S; 16],
        f: impl Fn(&S, &[f64; N]) -> [f64; N],
    ) -> Self {
        let mut slopes = [[0.0; N]; 16];
        let mut after = *y;
        let stages = STAGES.iter().chain(&DENSE_STAGES);
        for ((stage, weights), inputs) in stages.enumerate().zip(inputs) {
            let mut at = *y;
            add(&mut at, h, weights, &slopes);
            if stage == 12 {
                after = at;
            }
            slopes[stage] = f(inputs, &at);
        }
        let mut terms = [[0.0; N]; 7];
        let [change, first, second, others @ ..] = &mut terms;
        for i in 0..N {
            change[i] = after[i] - y[i];
            first[i] = h * slopes[0][i] - change[i];
            second[i] = 2.0 * change[i] - h * (slopes[0][i] + slopes[12][i]);
        }
        for (term, weights) in others.iter_mut().zip(DENSE_TERMS) {
            add(term, h, weights, &slopes);
        }
        Self {
            after,
            error: estimate(h, &slopes),
            begin: *y,
            terms,
        }
    }

    /// State at the fraction `share` of the step.
    #[must_use]
    pub fn at(&self, share: f64) -> [f64; N] {
        let mut y = [0.0; N];
        for (place, term) in self.terms.iter().enumerate().rev() {
            let factor = if place % 2 == 0 { share } else { 1.0 - share };
            for (y, term) in y.iter_mut().zip(term) {
                *y = (*y + term) * factor;
            }
        }
        for (y, begin) in y.iter_mut().zip(self.begin) {
            *y += begin;
        }
        y
    }
}

/// Adds the weighted slopes, multiplied by `h`.
#[inline(always)]
fn add<const N: usize, const STAGES: usize>(
    y: &mut [f64; N],
    h: f64,
    weights: &[(usize, f64)],
    slopes: &[[f64; N]; STAGES],
) {
    for (place, weight) in weights {
        let (slope, weight) = (&slopes[*place], h * weight);
        for i in 0..N {
            y[i] += weight * slope[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `exp(-4)` in so many steps, and the sum of the errors estimated.
    fn decayed(steps: u32) -> (f64, f64) {
        let h = 4.0 / f64::from(steps);
        let (mut y, mut errors) = ([1.0], 0.0);
        for _ in 0..steps {
            let (after, [error]) = dormand_prince_step(&y, h, &[(); 12], |(), y| [-y[0]]);
            y = after;
            errors += error;
        }
        (y[0], errors)
    }

    #[test]
    fn halving_the_step_divides_the_error_by_two_hundred_and_fifty_six_and_its_estimate_by_half_of_that()
     {
        let exact = libm::exp(-4.0);
        let ((coarse, coarse_estimate), (fine, fine_estimate)) = (decayed(12), decayed(24));
        let ratio = (coarse - exact) / (fine - exact);
        assert!((ratio / 256.0 - 1.0).abs() < 0.2, "{ratio}");
        let ratio = coarse_estimate / fine_estimate;
        assert!((ratio / 128.0 - 1.0).abs() < 0.2, "{ratio}");
    }

    #[test]
    fn a_polynomial_of_seventh_degree_in_time_is_integrated_exactly() {
        let times = DORMAND_PRINCE_NODES.map(|share| 2.0 * share);
        let ([y], _) = dormand_prince_step(&[0.0], 2.0, &times, |t: &f64, _| [8.0 * t.powi(7)]);
        assert!((y - 256.0).abs() < 1e-11, "{y}");
    }

    #[test]
    fn the_polynomial_through_a_step_errs_by_the_eighth_power_of_its_length() {
        let error = |h: f64| {
            let dense = DormandPrinceDense::new(&[1.0], h, &[(); 16], |(), y| [-y[0]]);
            let step = dormand_prince_step(&[1.0], h, &[(); 12], |(), y| [-y[0]]);
            assert_eq!((dense.after, dense.error), step);
            assert!((dense.at(1.0)[0] - dense.after[0]).abs() < 1e-15);
            dense.at(0.4)[0] - libm::exp(-0.4 * h)
        };
        let ratio = error(0.5) / error(0.25);
        assert!((ratio / 256.0 - 1.0).abs() < 0.2, "{ratio}");
    }

    #[test]
    fn each_stage_stands_where_the_inputs_are_asked_for() {
        for (weights, node) in STAGES.iter().zip(DORMAND_PRINCE_NODES) {
            let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
            assert!((sum - node).abs() < 1e-13, "{node}");
        }
    }
}
