"""Principal components of matrices that fit in memory, as those of a product with the identity."""

import numpy as np
from shrm.transfer.compression.components import PrincipalComponents
from shrm.transfer.compression.pca import factored


def exact(
    matrices: np.ndarray, *, K: int | None = None, accuracy: float | None = None
) -> PrincipalComponents:
    """Return the exact principal components of matrices (V, M^2, C, n^2)."""
    V, tents, C, terms = matrices.shape
    identity = np.eye(tents * C).reshape(tents, C, tents * C)
    return factored(identity, matrices.reshape(V, tents * C, terms), K=K, accuracy=accuracy)
