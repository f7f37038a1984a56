#include "haptics/probe/Spectrum.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"

#include <cmath>
#include <complex>
#include <vector>

#include <fmt/format.h>
#include <unsupported/Eigen/FFT>

namespace midair::haptics
{

Eigen::Index smoothLength(Eigen::Index most)
{
    Eigen::Index best = 1;
    for (Eigen::Index fives = 1; fives <= most; fives *= 5)
        for (Eigen::Index threes = fives; threes <= most; threes *= 3)
        {
            Eigen::Index twos = threes;
            while (2 * twos <= most)
                twos *= 2;
            best = std::max(best, twos);
        }
    return best;
}

Spectrum spectrumOf(const Eigen::VectorXd& values, double rate_Hz)
{
    if (values.size() < 2)
        throw base::InputError(
            fmt::format("spectrum: {} values; there must be at least 2", values.size()));
    if (!values.allFinite()) throw base::InputError("spectrum: a value is not finite");
    if (!(rate_Hz > 0.0) || !std::isfinite(rate_Hz))
        throw base::InputError(
            fmt::format("spectrum: the rate is {:g} Hz; it must be above 0", rate_Hz));

    const Eigen::Index n = smoothLength(values.size());
    // Without the mean, which would spread into the first frequencies with the window.
    const double mean = values.head(n).mean();
    std::vector<double> windowed;
    double sum = 0.0;
    for (Eigen::Index k = 0; k < n; ++k)
    {
        const double share = static_cast<double>(k) / static_cast<double>(n);
        const double window = 0.5 - 0.5 * std::cos(base::kTwoPi * share);
        windowed.push_back(window * (values[k] - mean));
        sum += window;
    }
    std::vector<std::complex<double>> lines;
    Eigen::FFT<double> transform;
    transform.fwd(lines, windowed);
    Spectrum spectrum;
    spectrum.step_Hz = rate_Hz / static_cast<double>(n);
    spectrum.amplitude.resize(n / 2 + 1);
    for (Eigen::Index k = 0; k < spectrum.amplitude.size(); ++k)
        spectrum.amplitude[k] = 2.0 / sum * std::abs(lines[static_cast<std::size_t>(k)]);
    spectrum.amplitude[0] = std::fabs(mean);
    return spectrum;
}

} // namespace midair::haptics
