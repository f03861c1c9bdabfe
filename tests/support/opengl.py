"""OpenGL for the tests: contexts, and what they may differ by from the CPU."""

from shrm.viewer import Context, offscreen
from shrm.viewer.gpu.context import ROUTES, ContextError, Route

from support.machine import require

SOFTWARE = ("llvmpipe", "softpipe", "swrast")


def context(*routes: Route) -> Context:
    """Make a context by one of these routes, or by any; see `support.machine.require`."""
    try:
        return offscreen(routes or ROUTES)
    except ContextError as fault:
        require(False, str(fault))
        raise


def lookup_error(context: Context, change: float) -> float:
    """Relative RMS error of the driver's look-ups in maps that change by `change` from texel to texel.

    Mesa's drivers on the CPU weigh texels in float32. Graphics hardware may do so in fixed point, NVIDIA's
    with 8 bits of fraction (CUDA C++ Programming Guide, "Linear Filtering"): a weight is off by 1/512 at
    most, that is by 1/512/sqrt(3) RMS, in each of the two dimensions.
    """
    if any(name in str(context.gl.info["GL_RENDERER"]) for name in SOFTWARE):
        return 0.0
    return change / 512 * (2 / 3) ** 0.5
