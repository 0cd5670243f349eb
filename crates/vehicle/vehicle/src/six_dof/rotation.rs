//! Attitude as a unit quaternion, from the body to the fixed frame (north, east, down).

use super::lanes::{Real, Three, dot};

/// `(q0, q1, q2, q3)`, scalar first. `Q` and `-Q` are the same attitude.
pub type Quaternion<T> = [T; 4];

/// Rotation matrix `R`, `v_fixed = R v_body`, of a quaternion of any length except 0.
#[inline(always)]
pub fn matrix<T: Real>([a, b, c, d]: Quaternion<T>) -> [Three<T>; 3] {
    let s = T::of(2.0) / (a * a + b * b + c * c + d * d);
    let one = T::of(1.0);
    [
        [
            one - s * (c * c + d * d),
            s * (b * c - a * d),
            s * (b * d + a * c),
        ],
        [
            s * (b * c + a * d),
            one - s * (b * b + d * d),
            s * (c * d - a * b),
        ],
        [
            s * (b * d - a * c),
            s * (c * d + a * b),
            one - s * (b * b + c * c),
        ],
    ]
}

/// `R v`: from the body to the fixed frame.
#[inline(always)]
pub fn to_fixed<T: Real>(r: &[Three<T>; 3], v: Three<T>) -> Three<T> {
    let [x, y, z] = *r;
    [dot(x, v), dot(y, v), dot(z, v)]
}

/// `R^T v`: from the fixed frame to the body.
#[inline(always)]
pub fn to_body<T: Real>(r: &[Three<T>; 3], v: Three<T>) -> Three<T> {
    let along = |i: usize| dot([r[0][i], r[1][i], r[2][i]], v);
    [along(0), along(1), along(2)]
}

/// `Q' = 1/2 Q (0, w)` for the body rates `w` (p, q, r) \[rad/s\].
#[inline(always)]
pub fn rate<T: Real>([a, b, c, d]: Quaternion<T>, [p, q, r]: Three<T>) -> Quaternion<T> {
    let half = T::of(0.5);
    [
        -(half * (b * p + c * q + d * r)),
        half * (a * p + c * r - d * q),
        half * (a * q + d * p - b * r),
        half * (a * r + b * q - c * p),
    ]
}

/// The quaternion scaled to length 1.
#[inline(always)]
pub fn normalised<T: Real>(q: Quaternion<T>) -> Quaternion<T> {
    let [a, b, c, d] = q;
    let length = (a * a + b * b + c * c + d * d).sqrt();
    [a / length, b / length, c / length, d / length]
}

/// Quaternion for roll, pitch and yaw \[rad\]: `R = Rz(yaw) Ry(pitch) Rx(roll)`.
#[must_use]
pub fn from_euler([roll, pitch, yaw]: Three<f64>) -> Quaternion<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(|x| libm::sincos(x / 2.0));
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
}

/// Roll, pitch and yaw \[rad\] of a quaternion.
#[must_use]
pub fn euler(q: Quaternion<f64>) -> Three<f64> {
    let r = matrix(q);
    [
        libm::atan2(r[2][1], r[2][2]),
        libm::asin((-r[2][0]).clamp(-1.0, 1.0)),
        libm::atan2(r[1][0], r[0][0]),
    ]
}
