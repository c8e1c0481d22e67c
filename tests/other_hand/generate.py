#!/usr/bin/env python3
"""Recordings of devices with something concealed, by a generator independent of the program: written
from the equations of the model and the catalogue alone, sharing no code, solver or, where there is
another one, form of a law with it. Needs what
requirements.txt lists.

Modal coordinates, event-driven RK4 (default 0.5 us), bisection of events, drive precomputed
open-loop on the step grid (right limit, middle, left limit of each step).
  python3 generate.py --effect ID|none|outside1|outside2|outside3 --seed N --out DIR
                 [--noise 20e-9] [--rate 50e3] [--xp-only] [--size FACTOR] [--h 0.5e-6]
  python3 generate.py --validate
"""
import os, sys
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")
import argparse, json, math
import numpy as np
from numba import njit

PI = math.pi
EPS0 = 8.8541878128e-12
CATALOGUE = ["amplifier_lag", "piezo_creep", "hysteresis_memory", "electrostatic", "extra_mode",
             "cubic_stiffness", "quadratic_drag", "dry_friction", "film_spring",
             "long_range_attraction", "adhesion_saturation", "velocity_restitution",
             "compliant_ground", "gap_step", "base_vibration", "zero_drift", "sensor_lag", "gravity"]
OUTSIDE = ["outside1", "outside2", "outside3"]

# ------------------------------------------------------------------ parameter vector of the solver
_names = """w1 w2 w3 z1 z2 z3 pc1 pc2 pc3 pp1 pp2 pp3 b1 b2 b3 ga1 ga2 ga3
eta Cs gp dp alpha Ca Ca0
es_A es_g es_d k3 k3sat cd fc fs_tau lr_A lr_h lr_n ad_dF ad_t1 ad_t2 ad_on vr_vy vr_cap vr_on
cg_k cg_A cg_on gs_d gs_t bv_a bv_w bv_ph grav o1_c o3_F o3_x o3_w""".split()
IX = {n: i for i, n in enumerate(_names)}
NP_ = len(_names)
for _n, _i in IX.items():
    globals()["i_" + _n] = _i


# ------------------------------------------------------------------ mechanics
@njit(cache=True)
def f_static(P, xp, xc, V):
    """forces on the mass that do not need a velocity (they act in flight and while held)"""
    F = -P[i_grav]
    if P[i_es_A] != 0.0:
        h = xp + P[i_es_g]
        F -= 0.5 * EPS0 * P[i_es_A] * V * V / (h * h - P[i_es_d] ** 2)   # plate with a tilt of +-d
    if P[i_k3] != 0.0:
        F -= P[i_k3] * xp ** 3 / (1.0 + (xp / P[i_k3sat]) ** 2)
    if P[i_lr_A] != 0.0:
        d = max(xp + P[i_dp], 0.0)
        # rough ground: three heights of asperities
        n = P[i_lr_n]; h = P[i_lr_h]
        a = (0.7 * h / (d + 0.7 * h)) ** n
        b = (h / (d + h)) ** n
        c = (1.3 * h / (d + 1.3 * h)) ** n
        F -= P[i_lr_A] * (a + 2 * b + c) / 4
    if P[i_o3_F] != 0.0:
        F += P[i_o3_F] * math.exp(-((xp - P[i_o3_x]) / P[i_o3_w]) ** 2)
    return F


@njit(cache=True)
def f_adh(P, tc):
    if P[i_ad_on] != 0.0:   # two populations of sites
        return P[i_Ca0] + P[i_ad_dF] * (1.0 - 0.5 * math.exp(-tc / P[i_ad_t1]) - 0.5 * math.exp(-tc / P[i_ad_t2]))
    return P[i_Ca0] + P[i_Ca] * tc


@njit(cache=True)
def rhs(P, y, g, V, t, mode, frs, tc0, dy):
    """y = q1..3, q'1..3, film state. mode 0 flight, 1 held by ground, 2 held by friction, 3 touching a soft ground.
    returns the net upward force on the mass if it were held (no film, no drag, no friction)"""
    xp = P[i_pp1] * y[0] + P[i_pp2] * y[1] + P[i_pp3] * y[2]
    xc = P[i_pc1] * y[0] + P[i_pc2] * y[1] + P[i_pc3] * y[2]
    vp = P[i_pp1] * y[3] + P[i_pp2] * y[4] + P[i_pp3] * y[5]
    F = f_static(P, xp, xc, V)
    film = 0.0
    dF = 0.0
    if mode == 0 or mode == 2:
        hh = xp + P[i_gp]
        film = -P[i_Cs] * vp / (hh * hh * hh)
    if P[i_fs_tau] > 0.0:
        dF = (film - y[6]) / P[i_fs_tau]
        film = y[6]
    if mode == 0:
        F += film - P[i_cd] * abs(vp) * vp - P[i_fc] * frs - P[i_o1_c] * V * vp
    elif mode == 3:
        d = -P[i_dp] - xp
        if d > 0.0:
            n = P[i_cg_k] * math.sqrt(d) * (d - 1.5 * P[i_cg_A] * vp)
            F += max(n, 0.0)
        F -= f_adh(P, t - tc0)
    Fd = P[i_eta] * g
    ab = 0.0
    if P[i_bv_a] != 0.0:
        ab = P[i_bv_a] * math.sin(P[i_bv_w] * t + P[i_bv_ph])
    s = 0.0
    m = 0.0
    for k in range(3):
        w = P[i_w1 + k]
        a = -2 * P[i_z1 + k] * w * y[3 + k] - w * w * y[k] + P[i_b1 + k] * Fd + P[i_pp1 + k] * F - P[i_ga1 + k] * ab
        dy[k] = y[3 + k]
        dy[3 + k] = a
        s += P[i_pp1 + k] * a
        m += P[i_pp1 + k] ** 2
    f = s / m
    if mode == 1 or mode == 2:
        for k in range(3):
            dy[3 + k] -= P[i_pp1 + k] * f
    dy[6] = dF
    return f


@njit(cache=True)
def quad(G, i, u):
    # parabola through u = 0, 1/2, 1
    a = G[i, 0]; b = G[i, 1]; c = G[i, 2]
    return a + u * (-3 * a + 4 * b - c) + u * u * (2 * a - 4 * b + 2 * c)


@njit(cache=True)
def rk4(P, y, G, VV, i, T0, H, s0, s1, mode, frs, tc0, yo, k1, k2, k3, k4, yt):
    h = s1 - s0
    u0 = s0 / H; u1 = s1 / H; um = 0.5 * (u0 + u1)
    gm = quad(G, i, um); vm = quad(VV, i, um)
    rhs(P, y, quad(G, i, u0), quad(VV, i, u0), T0 + s0, mode, frs, tc0, k1)
    for k in range(7): yt[k] = y[k] + 0.5 * h * k1[k]
    rhs(P, yt, gm, vm, T0 + s0 + 0.5 * h, mode, frs, tc0, k2)
    for k in range(7): yt[k] = y[k] + 0.5 * h * k2[k]
    rhs(P, yt, gm, vm, T0 + s0 + 0.5 * h, mode, frs, tc0, k3)
    for k in range(7): yt[k] = y[k] + h * k3[k]
    rhs(P, yt, quad(G, i, u1), quad(VV, i, u1), T0 + s1, mode, frs, tc0, k4)
    for k in range(7): yo[k] = y[k] + h / 6 * (k1[k] + 2 * k2[k] + 2 * k3[k] + k4[k])


@njit(cache=True)
def dotp(P, y, o):
    return P[i_pp1] * y[o] + P[i_pp2] * y[o + 1] + P[i_pp3] * y[o + 2]


@njit(cache=True)
def dotc(P, y, o):
    return P[i_pc1] * y[o] + P[i_pc2] * y[o + 1] + P[i_pc3] * y[o + 2]


@njit(cache=True)
def restitution(P, v):
    if P[i_vr_on] == 0.0:
        return P[i_alpha]
    # elastic - perfectly plastic sphere (Thornton 1997)
    r = P[i_vr_vy] / max(v, 1e-12)
    if r >= 1.0:
        return P[i_vr_cap]
    e = math.sqrt(6 * math.sqrt(3.0) / 5) * math.sqrt(1 - r * r / 6) * (r / (r + 2 * math.sqrt(1.2 - 0.2 * r * r))) ** 0.25
    return min(e, P[i_vr_cap])


@njit(cache=True)
def condval(P, yo, which, g, V, t, mode, frs, tc0, dp, tmp):
    """positive once the event has happened. which: 0 ground, 1 friction v zero, 2 ground release, 3 friction release, 4 leaves soft ground"""
    if which == 0:
        return -(dotp(P, yo, 0) + dp)
    if which == 1:
        return -dotp(P, yo, 3) * frs
    if which == 4:
        return dotp(P, yo, 0) + dp
    f = rhs(P, yo, g, V, t, mode, frs, tc0, tmp)
    if which == 2:
        return f - P[i_fc] - f_adh(P, t - tc0)
    return abs(f) - P[i_fc]


@njit(cache=True)
def simulate(P0, T0s, Hs, G, VV, y0, tq, xpq, xcq, ev):
    P = P0.copy()
    y = y0.copy()
    yo = np.empty(7); k1 = np.empty(7); k2 = np.empty(7); k3 = np.empty(7); k4 = np.empty(7); yt = np.empty(7); ya = np.empty(7); tmp = np.empty(7)
    m22i = P[i_pp1] ** 2 + P[i_pp2] ** 2 + P[i_pp3] ** 2
    mode = 0
    frs = 0.0
    tc0 = 0.0
    xh = 0.0
    stepped = False
    iq = 0
    nq = tq.size
    nev = 0
    guards = 0
    while iq < nq and tq[iq] <= 0.0:
        xpq[iq] = dotp(P, y, 0); xcq[iq] = dotc(P, y, 0); iq += 1
    if P[i_fc] > 0.0:
        mode = 2
        xh = dotp(P, y, 0)
    dp = P[i_dp]
    for i in range(T0s.size):
        T0 = T0s[i]; H = Hs[i]
        s = 0.0
        cnt = 0
        if P[i_gs_d] != 0.0 and (not stepped) and T0 >= P[i_gs_t] and mode == 0:
            if dotp(P, y, 0) > max(-dp, -(dp + P[i_gs_d])) + 0.5e-6:
                dp = dp + P[i_gs_d]
                P[i_dp] = dp
                stepped = True
                if nev < ev.shape[0]:
                    ev[nev, 0] = T0; ev[nev, 1] = 9; ev[nev, 2] = dp; ev[nev, 3] = 0; nev += 1
        while s < H * (1 - 1e-12):
            cnt += 1
            g0 = quad(G, i, s / H); v0 = quad(VV, i, s / H)
            # immediate releases (a jump of the drive)
            if mode == 1:
                if condval(P, y, 2, g0, v0, T0 + s, 1, frs, tc0, dp, tmp) > 0:
                    if nev < ev.shape[0]:
                        ev[nev, 0] = T0 + s; ev[nev, 1] = 2; ev[nev, 2] = rhs(P, y, g0, v0, T0 + s, 1, frs, tc0, tmp); ev[nev, 3] = T0 + s - tc0; nev += 1
                    mode = 0
                    frs = 1.0 if P[i_fc] > 0 else 0.0
            elif mode == 2:
                f = rhs(P, y, g0, v0, T0 + s, 2, frs, tc0, tmp)
                if abs(f) > P[i_fc]:
                    mode = 0
                    frs = 1.0 if f > 0 else -1.0
            h_end = H
            if mode == 3:
                h_end = min(H, s + H / 4 + 1e-15)
            elif cnt == 1 and mode == 0 and P[i_cg_on] == 0.0:
                h_end = H
            rk4(P, y, G, VV, i, T0, H, s, h_end, mode, frs, tc0, yo, k1, k2, k3, k4, yt)
            se = h_end
            best = -1
            if cnt < 200:
                for w in range(5):
                    if w == 0 and mode != 0: continue
                    if w == 1 and (mode != 0 or P[i_fc] == 0.0): continue
                    if w == 2 and mode != 1: continue
                    if w == 3 and mode != 2: continue
                    if w == 4 and mode != 3: continue
                    c = condval(P, yo, w, quad(G, i, h_end / H), quad(VV, i, h_end / H), T0 + h_end, mode, frs, tc0, dp, tmp)
                    if c <= 0: continue
                    lo = s; hi = h_end
                    for it in range(60):
                        mid = 0.5 * (lo + hi)
                        rk4(P, y, G, VV, i, T0, H, s, mid, mode, frs, tc0, ya, k1, k2, k3, k4, yt)
                        c = condval(P, ya, w, quad(G, i, mid / H), quad(VV, i, mid / H), T0 + mid, mode, frs, tc0, dp, tmp)
                        if c > 0: hi = mid
                        else: lo = mid
                        if hi - lo < 1e-17: break
                    if hi <= se:
                        se = hi; best = w
            else:
                guards += 1
            if best >= 0:
                rk4(P, y, G, VV, i, T0, H, s, se, mode, frs, tc0, yo, k1, k2, k3, k4, yt)
            if mode == 1 or mode == 2:
                e = (xh - dotp(P, yo, 0)) / m22i
                ev_ = dotp(P, yo, 3) / m22i
                for k in range(3):
                    yo[k] += P[i_pp1 + k] * e
                    yo[3 + k] -= P[i_pp1 + k] * ev_
            # samples by cubic Hermite inside (s, se]
            ta = T0 + s; tb = T0 + se
            if iq < nq and tq[iq] <= tb:
                hh = tb - ta
                pa = dotp(P, y, 0); pb = dotp(P, yo, 0); va = dotp(P, y, 3) * hh; vb = dotp(P, yo, 3) * hh
                ca = dotc(P, y, 0); cb = dotc(P, yo, 0); ua = dotc(P, y, 3) * hh; ub = dotc(P, yo, 3) * hh
                while iq < nq and tq[iq] <= tb:
                    u = (tq[iq] - ta) / hh if hh > 0 else 1.0
                    h00 = (1 + 2 * u) * (1 - u) ** 2; h10 = u * (1 - u) ** 2; h01 = u * u * (3 - 2 * u); h11 = u * u * (u - 1)
                    xpq[iq] = h00 * pa + h10 * va + h01 * pb + h11 * vb
                    xcq[iq] = h00 * ca + h10 * ua + h01 * cb + h11 * ub
                    iq += 1
            for k in range(7): y[k] = yo[k]
            s = se
            t = T0 + s
            g0 = quad(G, i, s / H); v0 = quad(VV, i, s / H)
            if best == 0 and P[i_cg_on] != 0.0:
                mode = 3; tc0 = t
                if nev < ev.shape[0]:
                    ev[nev, 0] = t; ev[nev, 1] = 3; ev[nev, 2] = dotp(P, y, 3); ev[nev, 3] = 0; nev += 1
            elif best == 0:
                vm = dotp(P, y, 3)
                e = (-dp - dotp(P, y, 0)) / m22i
                for k in range(3): y[k] += P[i_pp1 + k] * e
                al = restitution(P, -vm)
                J = -(1 + al) * vm / m22i
                for k in range(3): y[3 + k] += P[i_pp1 + k] * J
                f = rhs(P, y, g0, v0, t, 1, frs, t, tmp) - P[i_fc]
                if f > max(0.0, f_adh(P, 0.0)) and -vm > 1e-7:
                    frs = 1.0 if P[i_fc] > 0 else 0.0
                    if nev < ev.shape[0]:
                        ev[nev, 0] = t; ev[nev, 1] = 0; ev[nev, 2] = vm; ev[nev, 3] = -al * vm; nev += 1
                else:
                    J = -dotp(P, y, 3) / m22i
                    for k in range(3): y[3 + k] += P[i_pp1 + k] * J
                    mode = 1; xh = -dp; tc0 = t
                    if nev < ev.shape[0]:
                        ev[nev, 0] = t; ev[nev, 1] = 1; ev[nev, 2] = vm; ev[nev, 3] = f; nev += 1
            elif best == 1:
                xh = dotp(P, y, 0)
                e = dotp(P, y, 3) / m22i
                for k in range(3): y[3 + k] -= P[i_pp1 + k] * e
                f = rhs(P, y, g0, v0, t, 2, frs, tc0, tmp)
                if abs(f) <= P[i_fc]: mode = 2
                else: frs = 1.0 if f > 0 else -1.0
            elif best == 2:
                if nev < ev.shape[0]:
                    ev[nev, 0] = t; ev[nev, 1] = 2; ev[nev, 2] = rhs(P, y, g0, v0, t, 1, frs, tc0, tmp); ev[nev, 3] = t - tc0; nev += 1
                mode = 0
                frs = 1.0 if P[i_fc] > 0 else 0.0
            elif best == 3:
                f = rhs(P, y, g0, v0, t, 2, frs, tc0, tmp)
                mode = 0
                frs = 1.0 if f > 0 else -1.0
            elif best == 4:
                if nev < ev.shape[0]:
                    ev[nev, 0] = t; ev[nev, 1] = 4; ev[nev, 2] = dotp(P, y, 3); ev[nev, 3] = t - tc0; nev += 1
                mode = 0
    return nev, guards


# ------------------------------------------------------------------ waveforms and drive
class Wave:
    """list of breakpoints, voltage function right/left limits, direction per segment"""
    def __init__(self, kind, T, A, f, lam=0.0, f1=0.0):
        self.kind, self.T, self.A, self.f, self.lam, self.f1 = kind, T, A, f, lam, f1
        te = T + 60e-6
        if kind == "sine":
            b = (np.arange(int(te * f * 2) + 3) + 0.5) / (2 * f)
        elif kind == "square":
            b = np.arange(1, int(te * f * 2) + 3) / (2 * f)
        elif kind == "ramped":
            n = np.arange(int(te * f) + 2) / f
            b = np.concatenate([n, n + lam / f, n + 0.5 / f, n + (0.5 + lam) / f])
        elif kind == "chirp":
            k = (f1 - f) / (2 * T)
            ph = (np.arange(int(2 * (f * te + k * te * te)) + 3) + 0.5) / 2     # f t + k t^2 = ph
            b = (-f + np.sqrt(f * f + 4 * k * ph)) / (2 * k)
        b = np.sort(b[(b > 1e-12) & (b < te)])
        self.bp = np.concatenate([[0.0], b, [te]])

    def name(self):
        d = dict(sine="sine", square="square", ramped="ramped square", chirp="swept sine")[self.kind]
        s = f"{d} {self.f:g}" + (f" to {self.f1:g}" if self.kind == "chirp" else "") + f" Hz {self.A:g} V"
        if self.kind == "ramped": s += f" lambda {self.lam:g}"
        return s + f", {self.T:g} s"

    def v(self, t, tm):
        """voltage at t, the branch of the waveform being the one in force at tm"""
        t = np.asarray(t, float)
        if self.kind == "sine":
            return self.A * np.sin(2 * PI * self.f * t)
        if self.kind == "chirp":
            return self.A * np.sin(2 * PI * (self.f * t + (self.f1 - self.f) / (2 * self.T) * t * t))
        n = np.floor(np.asarray(tm) * self.f)
        um = tm * self.f - n
        if self.kind == "square":
            return np.where(um < 0.5, self.A, -self.A) + 0 * t
        u = t * self.f - n
        l = self.lam
        return self.A * np.where(um < l, -1 + 2 * u / l, np.where(um < 0.5, 1.0, np.where(um < 0.5 + l, 1 - 2 * (u - 0.5) / l, -1.0)))

    def dir(self, tm):
        """+1 rising, -1 falling, plateau keeps the last"""
        if self.kind in ("sine", "chirp"):
            e = 1e-9
            d = self.v(tm + e, tm) - self.v(tm - e, tm)
            return np.where(d > 0, 1, -1)
        um = np.asarray(tm) * self.f % 1.0
        return np.where(um < 0.5, 1, -1)

    def vsample(self, t):
        return self.v(t, t + 1e-10)


def gc_branch(V, d):
    return np.where(d > 0, 0.0016 * V**3 - 0.0255 * V**2 - 0.7057 * V + 1.4796, 0.0076 * V**2 - 0.6062 * V - 0.6350)


def grid(bp, h):
    T0, H = [], []
    for a, b in zip(bp[:-1], bp[1:]):
        if b - a < 1e-13: continue
        n = max(1, int(math.ceil((b - a) / h - 1e-9)))
        e = np.linspace(a, b, n + 1)
        T0.append(e[:-1]); H.append(np.diff(e))
    return np.concatenate(T0), np.concatenate(H)


@njit(cache=True)
def lag_filter(H, X, tau, y0):
    """tau y' = X - y, X linear over each half step; X may jump between steps"""
    Y = np.empty_like(X)
    y = y0
    for i in range(X.shape[0]):
        Y[i, 0] = y
        h = 0.5 * H[i]
        e = math.exp(-h / tau)
        for j in range(2):
            a = X[i, j]; b = X[i, j + 1]
            r = (b - a) / h
            # particular: a + r (t - tau)
            y = (y - (a - r * tau)) * e + (b - r * tau)
            Y[i, j + 1] = y
    return Y


@njit(cache=True)
def preisach(V, c, kap):
    """Preisach plane with density 2c-like, mu = c (1 + kap (alpha-beta)/16), demagnetised start; returns the hysteretic output"""
    out = np.empty_like(V)
    e = np.empty(4000); hv = np.empty(4000)
    m = 0
    d = 0.0
    vp = 0.0; hp = 0.0
    for i in range(V.shape[0]):
        for j in range(V.shape[1]):
            v = V[i, j]
            if v == vp:
                out[i, j] = hp
                continue
            dn = 1.0 if v > vp else -1.0
            if d != 0.0 and dn != d:
                m += 1
                e[m] = vp; hv[m] = hp
            d = dn
            while m >= 2 and d * (v - e[m - 1]) >= 0: m -= 2
            if m == 1 and d * (v + e[1]) >= 0: m = 0
            if m == 0:
                u = 2 * abs(v)
                h = c * (u * u / 2 + kap * u**3 / 96) * (1.0 if v > 0 else -1.0)
            else:
                u = abs(v - e[m])
                h = hv[m] + d * 2 * c * (u * u / 2 + kap * u**3 / 96)
            out[i, j] = h
            vp = v; hp = h
    return out


def drive(w, eff, p, h):
    """-> T0, H, G(n,3), V(n,3)"""
    bp = w.bp
    def nodes(bp):
        T0, H = grid(bp, h)
        tm = T0 + 0.5 * H
        V = np.stack([w.v(T0, tm), w.v(tm, tm), w.v(T0 + H, tm)], 1)
        return T0, H, tm, V
    T0, H, tm, V = nodes(bp)
    if eff == "amplifier_lag":
        tau = p["tau"]
        for it in range(2):
            L = lag_filter(H, V, tau, 0.0)
            D = V - L
            sg = np.where(np.abs(D) > 1e-9, np.sign(D), 0.0)
            if it == 0:       # put breakpoints where the lagged voltage turns round inside a step
                k = np.where(sg[:, 0] * sg[:, 2] < 0)[0]
                tx = T0[k] + H[k] * D[k, 0] / (D[k, 0] - D[k, 2])
                bp = np.unique(np.concatenate([bp, tx]))
                T0, H, tm, V = nodes(bp)
        d = sg[:, 1].copy()
        # hold where undecided
        idx = np.where(d != 0, np.arange(d.size), -1)
        idx = np.maximum.accumulate(idx)
        d = np.where(idx >= 0, d[np.maximum(idx, 0)], w.dir(tm[:1])[0])
        G = gc_branch(L, d[:, None])
        return T0, H, G, L
    d = w.dir(tm)
    G = gc_branch(V, d[:, None])
    if eff == "hysteresis_memory":
        hy = preisach(V, p["c"], p["kappa"])
        mean = 0.5 * (gc_branch(V, 1) + gc_branch(V, -1))
        sat = preisach(np.array([[0.0, 8.0]]), p["c"], p["kappa"])[0, 1]
        Gp = mean + sat * V / 8 - hy
        G = G + p["blend"] * (Gp - G)
    if eff == "piezo_creep":      # Kelvin-Voigt chain in series with the instantaneous strain
        S = np.zeros_like(G)
        for c, tau in zip(p["c"], p["tau"]):
            S += lag_filter(H, G, tau, 0.0) * c
            S -= c * 0.0
        if p["form"] == "excess":
            S -= sum(p["c"]) * G
        G = G + S
    return T0, H, G, V


# ------------------------------------------------------------------ device, effects, rig
PAPER = dict(f1=623.0, f2=6424.0, pc1=13381.005, pc2=74486.762, pp1=50145.332, pp2=-12923.177,
             eta=3.819e-7, Cs=1.747e-21, gp=70e-6, dp=58e-6, alpha=0.378, Ca=1.700e-6, Ca0=0.02743e-6, zeta1=0.0262, zeta2=0.0257)


def logu(r, a, b):
    return float(math.exp(r.uniform(math.log(a), math.log(b))))


def draw_device(seed):
    r = np.random.default_rng([seed, 11])
    d = dict(PAPER)
    for k in ("Cs", "Ca", "Ca0", "zeta1", "zeta2"): d[k] *= logu(r, 0.65, 1.5)
    for k in ("eta", "alpha"): d[k] *= logu(r, 0.8, 1.25)
    d["dp"] *= float(r.uniform(0.9, 1.1))
    d["gp"] = d["dp"] + float(r.uniform(8e-6, 16e-6))
    d["f1"] *= 1 + float(r.uniform(-0.01, 0.01))
    d["f2"] *= 1 + float(r.uniform(-0.01, 0.01))
    return d


def draw_effect(eff, seed, size, dev):
    r = np.random.default_rng([seed, 22])
    sg = 1.0 if r.random() < 0.5 else -1.0
    u = lambda a, b: float(r.uniform(a, b))
    l = lambda a, b: logu(r, a, b)
    if eff == "none": return {}
    if eff == "amplifier_lag": return dict(tau=l(40e-6, 120e-6) * size)
    if eff == "piezo_creep":
        ct = u(0.02, 0.06) * size
        w = u(0.3, 0.7)
        t1 = l(4e-3, 12e-3)
        return dict(c=[ct * w, ct * (1 - w)], tau=[t1, t1 * l(6, 14)], form="added")
    if eff == "hysteresis_memory":
        kap = u(-0.4, 0.4)
        c = u(0.8, 1.25) * 1.06 / 64
        return dict(c=c, kappa=kap, blend=1.0 * size)
    if eff == "electrostatic":
        return dict(A=900e-6 * 100e-6 * u(0.5, 1.0) * size, g=u(66e-6, 85e-6), tilt=u(1e-6, 4e-6))
    if eff == "extra_mode":
        return dict(f=l(9e3, 19e3), zeta=l(0.004, 0.015), phi_c=63144.79 * u(0.6, 1.2) * math.sqrt(size),
                    phi_p=sg * u(4000, 12000) * math.sqrt(size), drive_ratio=u(0.7, 1.3))
    if eff == "cubic_stiffness": return dict(k3=sg * l(1.2e4, 4e4) * size, x_soft=200e-6)
    if eff == "quadratic_drag": return dict(cd=l(8e-8, 4e-7) * size)
    if eff == "dry_friction": return dict(fc=l(3e-9, 12e-9) * size)
    if eff == "film_spring": return dict(tau=l(60e-6, 400e-6) * size)
    if eff == "long_range_attraction": return dict(A=l(15e-9, 45e-9) * size, h0=l(3e-6, 8e-6), n=int(r.integers(2, 4)))
    if eff == "adhesion_saturation":
        t = l(2e-3, 12e-3)
        return dict(dF=l(50e-9, 160e-9) * size, tau1=t, tau2=2.5 * t)
    if eff == "velocity_restitution": return dict(v_yield=l(1.5e-3, 6e-3) * size, cap=0.9)
    if eff == "compliant_ground": return dict(k_eq_1um=l(10.0, 40.0) / size)
    if eff == "gap_step": return dict(delta_dp=sg * u(0.8e-6, 3e-6) * size, t=u(0.06, 0.12))
    if eff == "base_vibration": return dict(a=l(3.0, 12.0) * size, f=l(40, 400))
    if eff == "zero_drift": return dict(a=sg * u(1.0e-6, 4e-6) * size, tau=l(0.03, 0.2))
    if eff == "sensor_lag": return dict(delay=l(18e-6, 60e-6) * size)
    if eff == "gravity": return dict(F=3.4276e-9 * u(0.9, 1.1) * size)
    if eff == "outside1": return dict(c=l(1.0e-8, 2.5e-8) * size)          # N s / (V m)
    if eff == "outside2": return dict(gain=0.01 * u(0.8, 1.2) * size, f=7.0, phase=u(0, 2 * PI))
    if eff == "outside3": return dict(F=sg * u(3e-9, 7e-9) * size, x=u(5e-6, 25e-6), w=u(5e-6, 10e-6))
    raise SystemExit("unknown effect " + eff)


def params(dev, eff, p, ph=0.0):
    P = np.zeros(NP_)
    S = lambda **k: [P.__setitem__(IX[a], b) for a, b in k.items()]
    S(w1=2 * PI * dev["f1"], w2=2 * PI * dev["f2"], w3=2 * PI * 19175.0, z1=dev["zeta1"], z2=dev["zeta2"], z3=0.02,
      pc1=dev["pc1"], pc2=dev["pc2"], pp1=dev["pp1"], pp2=dev["pp2"], b1=dev["pc1"], b2=dev["pc2"],
      eta=dev["eta"], Cs=dev["Cs"], gp=dev["gp"], dp=dev["dp"], alpha=dev["alpha"], Ca=dev["Ca"], Ca0=dev["Ca0"])
    S(k3sat=1.0, o3_w=1.0)
    if eff == "electrostatic": S(es_A=p["A"], es_g=p["g"], es_d=p["tilt"])
    if eff == "extra_mode":
        S(w3=2 * PI * p["f"], z3=p["zeta"], pc3=p["phi_c"], pp3=p["phi_p"], b3=p["phi_c"] * p["drive_ratio"])
    if eff == "cubic_stiffness": S(k3=p["k3"], k3sat=p["x_soft"])
    if eff == "quadratic_drag": S(cd=p["cd"])
    if eff == "dry_friction": S(fc=p["fc"])
    if eff == "film_spring": S(fs_tau=p["tau"])
    if eff == "long_range_attraction": S(lr_A=p["A"], lr_h=p["h0"], lr_n=p["n"])
    if eff == "adhesion_saturation": S(ad_on=1.0, ad_dF=p["dF"], ad_t1=p["tau1"], ad_t2=p["tau2"])
    if eff == "velocity_restitution": S(vr_on=1.0, vr_vy=p["v_yield"], vr_cap=p["cap"])
    if eff == "compliant_ground": S(cg_on=1.0, cg_k=p["k"], cg_A=p["A"])
    if eff == "gap_step": S(gs_d=p["delta_dp"], gs_t=p["t"])
    if eff == "base_vibration":
        ga = np.linalg.solve(np.array([[dev["pc1"], dev["pc2"]], [dev["pp1"], dev["pp2"]]]), np.ones(2))
        S(bv_a=p["a"], bv_w=2 * PI * p["f"], bv_ph=ph, ga1=ga[0], ga2=ga[1])
    if eff == "gravity": S(grav=p["F"])
    if eff == "outside1": S(o1_c=p["c"])
    if eff == "outside3": S(o3_F=p["F"], o3_x=p["x"], o3_w=p["w"])
    return P


def soft_ground(p, dev):
    """Kuwabara-Kono: k d^1.5 + 1.5 A k sqrt(d) d', with A set so that e(0.3 m/s) = alpha of the device"""
    k = p["k_eq_1um"] * 1e-6 / 1e-9     # force at 1 um equals that of a linear spring k_eq
    m = 1 / (dev["pp1"] ** 2 + dev["pp2"] ** 2)
    def e(A):
        d, v, h = 0.0, 0.3, 2e-8
        def acc(d, v):
            return -max(k * math.sqrt(max(d, 0)) * (d + 1.5 * A * v), 0.0) / m
        for i in range(5000):
            a1 = acc(d, v); a2 = acc(d + .5*h*v, v + .5*h*a1); a3 = acc(d + .5*h*(v + .5*h*a1), v + .5*h*a2); a4 = acc(d + h*(v + .5*h*a2), v + h*a3)
            d, v = d + h*(v + h*(a1+a2+a3)/6), v + h*(a1+2*a2+2*a3+a4)/6
            if d <= 0: return -v / 0.3
        return 0.0
    lo, hi = 0.0, 1e-4
    for _ in range(40):
        mid = .5 * (lo + hi)
        if e(mid) > dev["alpha"]: lo = mid
        else: hi = mid
    return dict(k_eq_1um=p["k_eq_1um"], k=k, A=.5 * (lo + hi), e_at_0p3=e(.5 * (lo + hi)))


FIT = [Wave("sine", .4, 8, 5), Wave("square", .2, 8, 15), Wave("square", .05, 6, 300), Wave("ramped", .4, 8, 5, .25), Wave("chirp", .3, 7, 1, f1=60)]
HELD = [Wave("ramped", .3, 8, 10, .15), Wave("sine", .2, 8, 15), Wave("square", .15, 7, 40), Wave("square", .05, 8, 300)]


def run(w, dev, eff, p, tq, h=0.5e-6, ph=0.0, y0=None):
    T0, H, G, V = drive(w, eff, p, h)
    P = params(dev, eff, p, ph)
    xp = np.full(tq.size, np.nan); xc = np.full(tq.size, np.nan)
    ev = np.zeros((20000, 4))
    n, guards = simulate(P, T0, H, np.ascontiguousarray(G), np.ascontiguousarray(V), np.zeros(7) if y0 is None else y0, tq, xp, xc, ev)
    return xp, xc, ev[:n], guards


def coloured(r, n, dt, rms, tau):
    a = math.exp(-dt / tau)
    from scipy.signal import lfilter
    e = r.normal(size=n) * math.sqrt(1 - a * a)
    e[0] = r.normal()
    return rms * (math.sqrt(.7) * r.normal(size=n) + math.sqrt(.3) * lfilter([1.0], [1.0, -a], e))


FORM = dict(
    amplifier_lag="RC: V_l integrated exactly, V_l(0)=0 (before t=0 the voltage is 0); branch chosen by the sign of V_l', held on plateaus",
    piezo_creep="Kelvin-Voigt chain of two elements added to the instantaneous strain: F = eta (gc + c1 z1 + c2 z2), z_i(0)=0",
    hysteresis_memory="Preisach, Everett function with density c (1+kappa (alpha-beta)/16), demagnetised at t=0, closing minor loops; gc = mean of both branches + sat V/8 - h; at 8 V close to the two branches",
    electrostatic="plate with tilt: -1/2 eps0 A V^2/((xp+g)^2 - tilt^2); also acts while held",
    extra_mode="third mode with its own shape, own drive gain phi_c*drive_ratio, excited by the ground impulse through phi_p, seen in both readings",
    cubic_stiffness="-k3 x^3/(1+(x/x_soft)^2), acts while held too",
    quadratic_drag="-cd |v| v in flight",
    dry_friction="set-valued Coulomb (exact stick and slip): holds the mass in flight while |net| <= fc; release from the ground needs f_pull > f_a + fc, the bounce test likewise",
    film_spring="Maxwell element: tau F' + F = film; F carries through bounces, decays while held and acts only in flight",
    long_range_attraction="mean of the law over three asperity heights 0.7, 1, 1.3 h0 (weights 1/4,1/2,1/4); acts while held too (d=0: A)",
    adhesion_saturation="two site populations, half each: f_a = Ca0 + dF (1 - e^(-t/tau1)/2 - e^(-t/tau2)/2), no linear Ca term",
    velocity_restitution="Thornton's elastic-plastic sphere with yield velocity, capped; alpha of the device unused (about v^-1/4)",
    compliant_ground="Kuwabara-Kono: k d^1.5 + 1.5 A k sqrt(d) d', never pulling, with adhesion f_a(t-tc) while d>0; film off while touching; alpha only sets A",
    gap_step="same time after the start of EVERY recording longer than t; takes effect once the mass is in flight above both levels",
    base_vibration="acceleration of base and ground, readings relative to the base; phase drawn for each recording; forces both points",
    zero_drift="both readings + a (1 - exp(-t/tau)), restarted in every recording",
    sensor_lag="pure delay of both readings, by exact sampling of the trajectory at t - delay",
    gravity="constant downward force on the mass, acts while held",
    outside1="force on the mass -c V xp' (voltage-dependent damping), flight only",
    outside2="gain of both readings 1 + gain sin(2 pi 7 t + phase), multiplying the motion before the zero offset",
    outside3="force on the mass F exp(-((xp-x)/w)^2): a bump at one height, at all times",
    none="nothing concealed")


def make(eff, seed, out, noise=20e-9, rate=50e3, xp_only=False, size=1.0, h=0.5e-6):
    dev = draw_device(seed)
    p = draw_effect(eff, seed, size, dev)
    if eff == "compliant_ground":
        p = soft_ground(p, dev)
        h = min(h, 0.25e-6)
    r = np.random.default_rng([seed, 33])
    skew = float(r.uniform(1e-6, 5e-6)) * (1 if r.random() < .5 else -1)
    scp, scc = 1 + float(r.uniform(-.01, .01)), 1 + float(r.uniform(-.01, .01))
    tau_n = logu(r, 0.3e-3, 1e-3)
    os.makedirs(out, exist_ok=True)
    recs = []
    for fn, w in [(f"fit{i+1}", w) for i, w in enumerate(FIT)] + [(f"held{i+1}", w) for i, w in enumerate(HELD)]:
        n = int(round(w.T * rate)) + 1
        t = np.arange(n) / rate
        dly = skew + (p["delay"] if eff == "sensor_lag" else 0.0)
        ph = float(r.uniform(0, 2 * PI))
        op, oc = float(r.uniform(-2e-6, 2e-6)), float(r.uniform(-2e-6, 2e-6))
        xp, xc, ev, guards = run(w, dev, eff, p, t - dly, h, ph)
        bp, bc, evb, _ = run(w, dev, "none", {}, t - skew, h)
        if eff == "zero_drift":
            z = p["a"] * (1 - np.exp(-t / p["tau"])); xp = xp + z; xc = xc + z
        if eff == "outside2":
            gn = 1 + p["gain"] * np.sin(2 * PI * p["f"] * t + p["phase"]); xp = xp * gn; xc = xc * gn
        assert np.all(np.isfinite(xp)) and np.all(np.isfinite(xc))
        t1 = min([e[0] for e in ev if e[1] in (0, 1, 3)] + [e[0] for e in evb if e[1] in (0, 1)] + [w.T])
        m = t < t1
        rms = lambda a: float(np.sqrt(np.mean(a ** 2))) * 1e6 if a.size else 0.0
        cnt = lambda E: {k: int(np.sum(E[:, 1] == c)) for k, c in dict(bounces=0, sticks=1, releases=2, soft_touches=3).items() if np.any(E[:, 1] == c)}
        recs.append(dict(file=fn + ".csv", excitation=w.name(), offset_xp=op, offset_xc=oc, base_phase=ph if eff == "base_vibration" else None,
                         events=cnt(ev), events_without_effect=cnt(evb), rms_change_before_first_impact_um=dict(xp=rms((xp - bp)[m]), xc=rms((xc - bc)[m])),
                         rms_change_whole_um=dict(xp=rms(xp - bp), xc=rms(xc - bc)), xp_min_um=float(xp.min() * 1e6), xp_max_um=float(xp.max() * 1e6),
                         first_impact_s=float(t1), step_guards=int(guards),
                         event_list=[[float(f"{a:.9g}") for a in e] for e in ev[:400]]))
        rp = scp * xp + op + coloured(r, n, 1 / rate, noise, tau_n)
        rc = scc * xc + oc + coloured(r, n, 1 / rate, noise, tau_n)
        cols = [t, w.vsample(t), rp * 1e6] + ([] if xp_only else [rc * 1e6])
        hd = "t [s],V [V],xp [um]" + ("" if xp_only else ",xc [um]")
        np.savetxt(os.path.join(out, fn + ".csv"), np.stack(cols, 1), fmt=["%.9f", "%.9f", "%.7f", "%.7f"][:len(cols)], delimiter=",", header=hd, comments="")
    truth = dict(effect=eff, seed=seed, size=size, parameters=p, formulation=FORM[eff], device=dev,
                 rig=dict(skew_reading_late_s=skew, scale_xp=scp, scale_xc=scc, noise_rms=noise, coloured_share=.3, coloured_tau=tau_n, rate=rate, step=h),
                 event_columns="t, type (0 bounce: v-,v+; 1 stick: v-, net pull; 2 release: net pull, contact time; 3 soft touch: v; 4 soft leave: v, contact time; 9 ground step: new dp)",
                 recordings=recs)
    json.dump(truth, open(os.path.join(out, "truth.json"), "w"), indent=1)
    return truth


def validate():
    import time
    dev = dict(PAPER)
    # (i) ring-down against the closed form, no film, no drive, no ground
    d0 = dict(dev, eta=0.0, Cs=0.0, dp=1.0, gp=2.0)
    y0 = np.array([1e-9, 2e-11, 0, 3e-6, -1e-6, 0, 0.0])
    t = np.arange(1001) * 20e-6
    xp, xc, _, _ = run(Wave("sine", .02, 0, 5), d0, "none", {}, t, y0=y0)
    ref = np.zeros_like(t)
    for q, v, f, z, a in ((y0[0], y0[3], dev["f1"], dev["zeta1"], dev["pp1"]), (y0[1], y0[4], dev["f2"], dev["zeta2"], dev["pp2"])):
        w = 2 * PI * f; wd = w * math.sqrt(1 - z * z)
        ref += a * np.exp(-z * w * t) * (q * np.cos(wd * t) + (v + z * w * q) / wd * np.sin(wd * t))
    print("(i) ring-down: amplitude %.2f um, largest error %.3g um" % (abs(ref).max() * 1e6, abs(xp - ref).max() * 1e6))
    d1 = dict(d0, zeta1=0.0, zeta2=0.0)
    T = np.arange(0, 2000) * 5e-6
    Pm = params(d1, "none", {})
    xp, xc, _, _ = run(Wave("sine", .02, 0, 5), d1, "none", {}, T, y0=y0)
    Phi = np.array([[dev["pc1"], dev["pc2"]], [dev["pp1"], dev["pp2"]]])
    q = np.linalg.solve(Phi, np.stack([xc, xp]))
    ws = 2 * PI * np.array([dev["f1"], dev["f2"]])
    for k in range(2):     # undamped: each mode's amplitude from a fit of sin, cos over the first and last quarter
        A = np.stack([np.cos(ws[k] * T), np.sin(ws[k] * T)], 1)
        a0 = np.linalg.norm(np.linalg.lstsq(A[:500], q[k, :500], rcond=None)[0]); a1 = np.linalg.norm(np.linalg.lstsq(A[-500:], q[k, -500:], rcond=None)[0])
        print("    undamped mode %d energy drift over 10 ms: %.2e" % (k + 1, (a1 / a0) ** 2 - 1))
    M = np.linalg.inv(Phi @ Phi.T); print("    M [1e-10 kg]", (M * 1e10).round(4).tolist())
    # static gain
    print("    static um per unit: %.3f" % (dev["eta"] * 1e6 * sum(dev["pc%d" % k] * dev["pp%d" % k] / ws[k - 1] ** 2 for k in (1, 2))))
    # (ii) step halving
    for eff in ["none"] + CATALOGUE + OUTSIDE:
        p = draw_effect(eff, 5, 1.0, dev)
        if eff == "compliant_ground": p = soft_ground(p, dev)
        worst = 0; evs = []
        for w in FIT + HELD:
            t = np.arange(int(w.T * 50e3)) / 50e3
            a = run(w, dev, eff, p, t, 0.5e-6); b = run(w, dev, eff, p, t, 0.25e-6)
            te = [x[2][x[2][:, 1] <= 3][:1, 0] for x in (a, b)]
            tt = min([float(x[0]) for x in te if x.size] + [1.0]) - 1e-5
            m = t < tt
            if m.any(): worst = max(worst, abs(a[0] - b[0])[m].max(), abs(a[1] - b[1])[m].max())
            ea, eb = [x[2][x[2][:, 1] != 9] for x in (a, b)]
            nn = min(len(ea), len(eb)); same = (ea[:nn, 1] == eb[:nn, 1]); kk = nn if same.all() else int(np.argmin(same))
            evs.append("%d/%d same %d dt %.1e" % (len(ea), len(eb), kk, abs(ea[:kk, 0] - eb[:kk, 0]).max() if kk else 0) + (" G%d" % a[3] if a[3] else ""))
        print("(ii) %-22s before first impact: %.2e um; events h/h2: %s" % (eff, worst * 1e6, "; ".join(evs)), flush=True)
    # (iii)
    for w in FIT + HELD:
        t = np.arange(int(w.T * 50e3)) / 50e3
        t0 = time.time(); xp, xc, ev, g = run(w, dev, "none", {}, t)
        print("(iii) %-45s xp %.1f..%.1f um, bounces %d sticks %d releases %d, max v- %.3f m/s, contact ms %s  (%.2f s)" % (
            w.name(), xp.min() * 1e6, xp.max() * 1e6, (ev[:, 1] == 0).sum(), (ev[:, 1] == 1).sum(), (ev[:, 1] == 2).sum(),
            -min([e[2] for e in ev if e[1] < 2] + [0]), [round(e[3] * 1e3, 2) for e in ev if e[1] == 2][:6], time.time() - t0))


if __name__ == "__main__":
    ap = argparse.ArgumentParser()
    ap.add_argument("--effect", default="none"); ap.add_argument("--seed", type=int, default=0); ap.add_argument("--out")
    ap.add_argument("--noise", type=float, default=20e-9); ap.add_argument("--rate", type=float, default=50e3)
    ap.add_argument("--xp-only", action="store_true"); ap.add_argument("--size", type=float, default=1.0)
    ap.add_argument("--h", type=float, default=0.5e-6); ap.add_argument("--validate", action="store_true")
    a = ap.parse_args()
    if a.validate: validate(); sys.exit()
    if a.effect not in ["none"] + CATALOGUE + OUTSIDE: ap.error("unknown effect; one of none " + " ".join(CATALOGUE + OUTSIDE))
    if not a.out: ap.error("--out needed")
    tr = make(a.effect, a.seed, a.out, a.noise, a.rate, a.xp_only, a.size, a.h)
    print(a.effect, "seed", a.seed, "->", a.out)
