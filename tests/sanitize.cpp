// Every function of the core on small and odd sizes, built and run under ASan and UBSan by
// test_sanitizers.py. Values are the business of the Python tests; here only memory and
// undefined behaviour are watched, so each stage needs just a few calls.
#include <cstdio>

#include "shrm/core.hpp"

namespace {

void core() {
    for (int F = 0; F < 4; ++F)
        for (int l = 0; l <= F; ++l)
            for (int m = -l; m <= l; ++m)
                if (shrm::lm(l, m) >= shrm::basis_size(F)) std::puts("index outside the basis");
}

}  // namespace

int main() {
    core();
    std::puts("sanitize: done");
}
