#include "haptics/propagation/PressureField.h"
#include "haptics/scattering/Scatterer.h"

#include <algorithm>

namespace midair::haptics
{

IncidentField incidentField(const Eigen::Matrix3Xd& places,
                            const Eigen::Matrix3Xd& normals,
                            const TransducerArray& array,
                            const Medium& medium,
                            const Eigen::VectorXcf& activations,
                            int threads,
                            const base::StopToken& stop)
{
    // f' = (8 (f1 - f-1) - (f2 - f-2)) / 12 h: (kh)^4/30 = 3e-4 off.
    const double step_m = 0.05 * medium.wavelength(array.frequency_Hz);
    constexpr int kShifts = 5;
    constexpr Eigen::Index kChunk = 4096;
    const Eigen::Index n = places.cols();
    IncidentField field{Eigen::VectorXcd(n), Eigen::VectorXcd(n)};
    for (Eigen::Index first = 0; first < n; first += kChunk)
    {
        const Eigen::Index count = std::min(kChunk, n - first);
        Eigen::Matrix3Xd shifted(3, kShifts * count);
        for (int shift = 0; shift < kShifts; ++shift)
            shifted.middleCols(shift * count, count) =
                places.middleCols(first, count) +
                (shift - 2) * step_m * normals.middleCols(first, count);
        const Eigen::VectorXcd p = pressureAt(shifted, array, medium, activations, threads, stop)
                                       .cast<std::complex<double>>();
        const auto at = [&](int shift) { return p.segment((shift + 2) * count, count); };
        field.pressure_Pa.segment(first, count) = at(0);
        field.slope_Pa_m.segment(first, count) =
            (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * step_m);
    }
    return field;
}

} // namespace midair::haptics
