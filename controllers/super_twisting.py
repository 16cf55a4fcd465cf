"""The super-twisting law: a second-order sliding mode that drives s and ds/dt to zero without a relay.

For ds/dt = b u + phi with the authority b > 0 and a disturbance that changes at most at D, |d phi / dt| <= D,

    b u = -k_1 sqrt(|s|) sign(s) + w,    dw/dt = -k_2 sign(s),    k_1 = 1.5 sqrt(D),  k_2 = 1.1 D

brings s and ds/dt to zero in finite time (A. Levant, Sliding order and sliding accuracy in sliding mode control, Int.
J. Control 58, 1993; the gains: A. Levant, Robust exact differentiation via sliding mode technique, Automatica 34,
1998).
The sign is integrated, so u is continuous; w converges to -phi.

The discretisation is implicit: signs are those of the next s (B. Brogliato, A. Polyakov, D. Efimov, The
implicit discretization of the super-twisting sliding-mode control algorithm, IEEE Trans. Autom. Control 65, 2020): so s
does not chatter. With z the next s of the undisturbed plant,

    z + dt k_1 sqrt(|z|) sign(z) + dt^2 k_2 sign(z) = s + dt w

is quadratic in sqrt(|z|), with z = 0 where the right side is at most dt^2 k_2. The remaining s = dt phi is smooth; the
explicit law would leave jumps of the order of dt^2.
"""

from math import copysign, sqrt


class SuperTwisting:
    """The law with its integrator w, rad/s^2."""

    def __init__(self, disturbance_radps3: float, dt_s: float) -> None:
        self.k1 = 1.5 * sqrt(disturbance_radps3)
        self.k2 = 1.1 * disturbance_radps3
        self._dt_s = dt_s
        self.w_radps2 = 0.0

    def rate(self, s_radps: float, authority_per_s: float, limit_radps: float) -> float:
        """u, rad/s, for a step that begins at s; |u| <= `limit_radps`, and w is limited accordingly."""
        dt = self._dt_s
        ahead = s_radps + dt * self.w_radps2
        over = abs(ahead) - dt**2 * self.k2
        if over > 0.0:
            root = 0.5 * (sqrt((dt * self.k1) ** 2 + 4.0 * over) - dt * self.k1)
            pull = copysign(self.k1 * root, ahead)
            w = self.w_radps2 - copysign(dt * self.k2, ahead)
        else:
            pull, w = 0.0, -s_radps / dt
        limit = authority_per_s * limit_radps
        self.w_radps2 = min(max(w, -limit), limit)
        return min(max((self.w_radps2 - pull) / authority_per_s, -limit_radps), limit_radps)
