"""A model with the coefficient file that it came from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import control
    import pandas as pd

    from gen.coefficients import Coefficients


@dataclass(frozen=True)
class Model:
    """A checked coefficient file: what :func:`gen.load`, :func:`gen.identify` and :func:`gen.refine` give.

    Parameters
    ----------
    coefficients
        The file's content, checked.
    text
        The file itself.
    path
        Where it was read from; None for a model that was made in memory.

    Examples
    --------
    >>> import gen
    >>> motor = gen.load("examples/my1016/coeffs.json")
    >>> motor.components
    ('brush', 'bearing', 'magnet', 'casing')
    >>> rise = 153 * motor.transfer_function("casing", 153).dcgain()  # K
    >>> f"{rise:.2f}"
    '34.43'
    """

    coefficients: Coefficients
    text: str
    path: Path | None = None

    @property
    def name(self) -> str:
        """The model's name."""
        return self.coefficients.name

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the parts, in the order of the file."""
        return self.coefficients.model.component_names

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is allowed and yet worth a look, one sentence each."""
        return self.coefficients.warnings

    def transfer_functions_only(self, what: str) -> None:
        """Refuse a network.

        Parameters
        ----------
        what
            What cannot take one, for the message.

        Raises
        ------
        InputError
            If the model is a network.
        """
        from gen.coefficients import transfer_functions_only

        transfer_functions_only(self.coefficients, what, None if self.path is None else str(self.path))

    def transfer_function(self, component: str, pwm: int) -> control.TransferFunction:
        """Temperature rise (K) over PWM (counts) at a speed, as a python-control system without effects.

        Parameters
        ----------
        component
            Name of the part.
        pwm
            PWM in counts, 0..255; the sign does not matter.

        Raises
        ------
        KeyError
            If the model has no such part.
        InputError
            If the model is a network.
        """
        self.transfer_functions_only("transfer_function()")
        return self.coefficients.model.transfer_function(component, pwm)

    def steady_rise(self) -> pd.DataFrame:
        """Steady temperature rise in K of each part (columns) at |PWM| (rows) within the domain, without effects.

        Raises
        ------
        InputError
            If the model is a network.
        """
        import numpy as np
        import pandas as pd

        self.transfer_functions_only("steady_rise()")

        model = self.coefficients.model
        rows = np.arange(model.domain_pwm[0], model.domain_pwm[1] + 1)
        rises = {part.name: part.steady_rise(rows) for part in model.components}
        return pd.DataFrame(rises, index=pd.Index(rows, name="pwm"))

    def save(self, path: Path | str) -> None:
        """Write the coefficient file; it appears complete or not at all.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        from gen.files import write_text

        write_text(Path(path), self.text)

    def __repr__(self) -> str:
        return f"Model({self.name!r}, {len(self.components)} parts: {', '.join(self.components)})"
