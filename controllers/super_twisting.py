"""The super-twisting law, the second-order sliding mode of the paper's reference: s and ds/dt both to zero, no relay.

For ds/dt = b u + phi with the authority b > 0 and a disturbance that changes at most at D, |d phi / dt| <= D,

    b u = -k_1 sqrt(|s|) sign(s) + w,    dw/dt = -k_2 sign(s),    k_1 = 1.5 sqrt(D),  k_2 = 1.1 D

brings s and ds/dt to zero in finite time (A. Levant, Sliding order and sliding accuracy in sliding mode control, Int.
J. Control 58, 1993; the gains: A. Levant, Robust exact differentiation via sliding mode technique, Automatica 34,
1998).
The relay is behind an integrator, so u is continuous; w becomes -phi.

In time steps of dt the signs are those of the next s, not of the last (B. Brogliato, A. Polyakov, D. Efimov, The
implicit discretization of the super-twisting sliding-mode control algorithm, IEEE Trans. Autom. Control 65, 2020): s is
then not thrown from one side to the other at every step. With z the next s of the undisturbed plant,

    z + dt k_1 sqrt(|z|) sign(z) + dt^2 k_2 sign(z) = s + dt w

is a quadratic equation in sqrt(|z|), and has z = 0 where the right side is at most dt^2 k_2. What is left is s = dt
phi: smooth, where the explicit law would leave jumps of the order of dt^2.
"""

from math import copysign, sqrt


class SuperTwisting:
    """The law with its integrator w, rad/s^2."""

    def __init__(self, disturbance_radps3: float, dt_s: float) -> None:
        self.k1 = 1.5 * sqrt(disturbance_radps3)
        self.k2 = 1.1 * disturbance_radps3
        self._dt_s = dt_s
        self.w_radps2 = 0.0

    def rate(self, s_radps: float, authority_per_s: float, most_radps: float) -> float:
        """u, rad/s, of the step that begins with s; |u| <= `most_radps`, and w no larger than that can serve."""
        dt = self._dt_s
        ahead = s_radps + dt * self.w_radps2
        over = abs(ahead) - dt**2 * self.k2
        if over > 0.0:
            root = 0.5 * (sqrt((dt * self.k1) ** 2 + 4.0 * over) - dt * self.k1)
            pull = copysign(self.k1 * root, ahead)
            w = self.w_radps2 - copysign(dt * self.k2, ahead)
        else:
            pull, w = 0.0, -s_radps / dt
        most = authority_per_s * most_radps
        self.w_radps2 = min(max(w, -most), most)
        return min(max((self.w_radps2 - pull) / authority_per_s, -most_radps), most_radps)
