"""Least squares on simulated outputs, with intervals that allow for correlated residuals."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats

Z95 = 1.959963984540054
"""Half the width of a 95 % interval in standard deviations."""
_NOISE_LIMIT = 0.999
_ROUNDS = 3
"""Alternations between the estimation of parameters and noise."""
_FLOOR = 1e-12


class Model(NamedTuple):
    """
    Outputs of a robot as a function of its parameters.

    Attributes
    ----------
    names : tuple of str
        Of the parameters.
    start, lower, upper, steps : array of float, shape (p,)
        Start of a search, its bounds, and the steps of its differences.
    outputs : callable
        Takes parameters; returns an array of shape (n, 2) for each recording.
    """

    names: tuple[str, ...]
    start: Floats
    lower: Floats
    upper: Floats
    steps: Floats
    outputs: Callable[[Floats], list[Floats]]


class ResidualNoise(NamedTuple):
    """
    ResidualNoise of one output: e[k] = φ e[k-1] + η[k] - θ η[k-1].

    White noise of a position makes θ = 1 for its differences; a persistent disturbance makes φ > 0.

    Attributes
    ----------
    ar, ma : float
        φ, θ.
    deviation : float
        Of η.
    """

    ar: float
    ma: float
    deviation: float


class Estimate(NamedTuple):
    """
    Parameters with their covariance.

    Attributes
    ----------
    names : tuple of str
        Of the parameters.
    values : array of float, shape (p,)
        Estimates.
    covariance : array of float, shape (p, p)
        Of the estimates.
    residuals : list of array of float, shape (n, 2)
        Measured minus modelled, one recording each.
    whitened : array of float, shape (n, 2)
        Residuals of all recordings without their correlation, in standard deviations.
    noise : tuple of ResidualNoise
        Of both outputs.
    """

    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    residuals: list[Floats]
    whitened: Floats
    noise: tuple[ResidualNoise, ...]

    @property
    def deviations(self) -> Floats:
        """Standard deviations of the estimates, shape (p,)."""
        found: Floats = np.sqrt(np.diag(self.covariance))
        return found

    @property
    def cost(self) -> float:
        """Minus twice the log-likelihood, up to a constant."""
        return 2.0 * self.whitened.shape[0] * sum(float(np.log(one.deviation)) for one in self.noise)


def whitened(residuals: Sequence[Floats], noise: Sequence[ResidualNoise]) -> Floats:
    """Return residuals of all recordings without their correlation, in standard deviations."""
    from scipy.signal import lfilter  # noqa: PLC0415 (imported late: most commands do without)

    return np.concatenate([
        np.column_stack([lfilter([1.0, -one.ar], [1.0, -one.ma], part[:, n]) / one.deviation
                         for n, one in enumerate(noise)]) for part in residuals])


def estimate_noise(residuals: Sequence[Floats]) -> tuple[ResidualNoise, ...]:
    """Estimate the noise of each output from residuals."""
    from scipy.optimize import minimize  # noqa: PLC0415 (late, as above)

    def of_output(n: int) -> ResidualNoise:
        def deviation(coefficients: Floats) -> float:
            parts = [part[:, n:n + 1] for part in residuals]
            noise = ResidualNoise(coefficients[0], coefficients[1], 1.0)
            return float(np.sqrt((whitened(parts, [noise]) ** 2).mean())) + _FLOOR

        fitted = min((minimize(lambda coefficients: np.log(deviation(coefficients)), start, method='L-BFGS-B',
                               bounds=[(-_NOISE_LIMIT, _NOISE_LIMIT)] * 2)
                      for start in ((0.0, 0.0), (0.5, 0.9), (0.9, 0.5))), key=lambda one: one.fun)
        return ResidualNoise(float(fitted.x[0]), float(fitted.x[1]), deviation(fitted.x))

    return tuple(map(of_output, range(residuals[0].shape[1])))


def jacobian(model: Model, values: Floats) -> list[list[Floats]]:
    """Return the derivatives of the outputs with respect to each parameter: a list of recordings a parameter."""
    here, derivatives = model.outputs(values), []
    for n, step in enumerate(model.steps):
        beside = values.copy()
        beside[n] += step if values[n] + step < model.upper[n] else -step
        derivatives.append([(one - other) / (beside[n] - values[n])
                            for one, other in zip(model.outputs(beside), here, strict=True)])
    return derivatives


def _fit(model: Model, measured: Sequence[Floats], start: Floats, noise: Sequence[ResidualNoise]) -> Floats:
    """Return the parameters with the smallest whitened residuals."""
    from scipy.optimize import least_squares  # noqa: PLC0415 (late, as above)

    def residuals(values: Floats) -> Floats:
        return whitened(_differences(measured, model.outputs(values)), noise).ravel()

    def derivatives(values: Floats) -> Floats:
        return np.column_stack([-whitened(one, noise).ravel() for one in jacobian(model, values)])

    inside = np.clip(start, model.lower + 1e-9, model.upper - 1e-9)
    fitted = least_squares(residuals, inside, derivatives, (model.lower, model.upper), x_scale=model.steps, ftol=1e-8,
                           xtol=1e-9, max_nfev=40)
    values: Floats = fitted.x
    return values


def _differences(measured: Sequence[Floats], modelled: Sequence[Floats]) -> list[Floats]:
    return [one - other for one, other in zip(measured, modelled, strict=True)]


def estimate(
    model: Model, measured: Sequence[Floats], rounds: int = _ROUNDS, tell: Callable[[], object] = lambda: None
) -> Estimate:
    """
    Estimate the parameters of a model.

    Generalised least squares on the simulated output, in alternation with the noise of each output. The covariance is
    that of White (1980) after the whitening; the remaining correlation over a few samples is treated as by Newey and
    West (1987).

    Parameters
    ----------
    model : Model
        With a start.
    measured : sequence of array of float, shape (n, 2)
        One recording each, as the model's outputs.
    rounds : int
        Number of alternations between noise and parameters.
    tell : callable
        Called after each round.
    """
    values = model.start
    noise = estimate_noise(_differences(measured, model.outputs(values)))
    for turn in range(rounds):
        # before the parameters are near, residuals are no noise, but show the scale of each output
        values = _fit(model, measured, values, noise if turn else [
            ResidualNoise(0.0, 0.0, one.deviation) for one in noise])
        noise = estimate_noise(_differences(measured, model.outputs(values)))
        tell()
    residuals = _differences(measured, model.outputs(values))
    white = whitened(residuals, noise)
    sensitivities: Floats = np.stack([whitened(one, noise) for one in jacobian(model, values)], axis=-1)
    return Estimate(model.names, values, _covariance(sensitivities, white), residuals, white, noise)


def _covariance(sensitivities: Floats, white: Floats) -> Floats:
    """Return the covariance of parameters from sensitivities, shape (n, 2, p), and residuals, shape (n, 2)."""
    information = np.einsum('koi,koj->ij', sensitivities, sensitivities)
    inverse = _inverse(information)
    scores = np.einsum('koi,ko->ki', sensitivities, white)
    count = scores.shape[0]
    spread = scores.T @ scores
    lags = int(4.0 * (count / 100.0) ** (2.0 / 9.0))
    for lag in range(1, lags + 1):
        shared = scores[lag:].T @ scores[:-lag]
        spread += (1.0 - lag / (lags + 1.0)) * (shared + shared.T)
    covariance: Floats = inverse @ spread @ inverse * count / max(1, count - inverse.shape[0])
    return covariance


def _inverse(information: Floats) -> Floats:
    """Return the inverse of an information matrix; huge, instead of an error, in directions without information."""
    scale = np.sqrt(np.diag(information)) + _FLOOR
    lengths, axes = np.linalg.eigh(information / np.outer(scale, scale))
    inverse: Floats = (axes / np.maximum(lengths, _FLOOR)) @ axes.T / np.outer(scale, scale)
    return inverse
