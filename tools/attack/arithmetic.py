"""Arithmetic that is the same text for long doubles (64 bits, dtype `g`) and for mpmath numbers (any digits, dtype object).

Arrays of mpmath numbers know + - * / and matmul; what else is needed stands here.
"""
import mpmath
import numpy as np

LONG = np.longdouble
mpmath.mp.dps = 50


def number(x, exact):
    """A Python number as a long double, or as an mpmath number where `exact`."""
    return mpmath.mpf(x) if exact else LONG(x)


def array(x, exact):
    """A list or array of doubles as an array of long doubles or of mpmath numbers."""
    x = np.asarray(x, dtype=float)
    if not exact:
        return x.astype(LONG)
    out = np.empty(x.shape, dtype=object)
    for index, value in np.ndenumerate(x):
        out[index] = mpmath.mpf(float(value))
    return out


def zeros(shape, exact):
    """Zeros of that kind."""
    return array(np.zeros(shape), exact)


def exact_of(x):
    """Whether an array holds mpmath numbers."""
    return x.dtype == object


def _each(function, x):
    out = np.empty(x.shape, dtype=object)
    for index, value in np.ndenumerate(x):
        out[index] = function(value)
    return out


def cos(x):
    return _each(mpmath.cos, x) if exact_of(x) else np.cos(x)


def sin(x):
    return _each(mpmath.sin, x) if exact_of(x) else np.sin(x)


def sqrt(x):
    return _each(mpmath.sqrt, x) if exact_of(x) else np.sqrt(x)


def double(x):
    """The nearest doubles."""
    return np.asarray(x).astype(float)


def epsilon(exact):
    """Unit of rounding."""
    return float(mpmath.eps) if exact else float(np.finfo(LONG).eps)


def cholesky(a):
    """L with L L' = a, by the textbook, as LAPACK knows doubles only."""
    n, low = len(a), zeros(a.shape, exact_of(a))
    for i in range(n):
        for j in range(i + 1):
            rest = a[i, j] - sum((low[i, k] * low[j, k] for k in range(j)), a[0, 0] * 0)
            low[i, j] = sqrt(np.array([rest]))[0] if i == j else rest / low[j, j]
    return low


def solve_lower(low, b):
    """L^-1 b, for a vector or the columns of a matrix."""
    x = b.copy()
    for i in range(len(low)):
        for k in range(i):
            x[i] = x[i] - low[i, k] * x[k]
        x[i] = x[i] / low[i, i]
    return x


def eigen(a):
    """Eigenvalues and orthonormal eigenvectors (columns) of a symmetric matrix, by cyclic Jacobi rotations."""
    exact, n = exact_of(a), len(a)
    a, vectors = a.copy(), array(np.eye(n), exact)
    small = epsilon(exact) ** 2
    for _ in range(60):
        off = sum(float(a[i, j]) ** 2 for i in range(n) for j in range(i))
        if off <= small * sum(float(a[i, i]) ** 2 for i in range(n)):
            break
        for p in range(n):
            for q in range(p + 1, n):
                if a[p, q] == 0:
                    continue
                theta = (a[q, q] - a[p, p]) / (2 * a[p, q])
                root = sqrt(np.array([theta * theta + 1]))[0]
                t = 1 / (theta + root) if theta >= 0 else 1 / (theta - root)
                c = 1 / sqrt(np.array([t * t + 1]))[0]
                s = t * c
                rows = a[[p, q]].copy()
                a[p], a[q] = c * rows[0] - s * rows[1], s * rows[0] + c * rows[1]
                for m in (a, vectors):
                    left, right = m[:, p].copy(), m[:, q].copy()
                    m[:, p], m[:, q] = c * left - s * right, s * left + c * right
    return np.diag(a).copy(), vectors


def dot(a, b):
    """Products of rows: sum over the last axis."""
    return (a * b).sum(axis=-1)
