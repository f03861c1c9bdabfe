"""Operations on any lobe, by whatever method: directions, quadrature, centers, splits, factored forms."""
