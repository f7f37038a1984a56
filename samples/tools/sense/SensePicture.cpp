#include "samples/tools/sense/SensePicture.h"

#include "haptics/base/Units.h"
#include "samples/shared/views/CurvePlot.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

namespace midair::samples
{

namespace
{

constexpr double kMostSpectrum_Hz = 500.0; // skin feels nothing above
constexpr Eigen::Index kMostOfSpectrum = 4000;

Curve curveOf(const Eigen::VectorXd& x, const Eigen::VectorXd& y, const std::string& name)
{
    Curve curve;
    curve.x = x;
    curve.y = y;
    curve.name = name;
    return curve;
}

/// Returns amplitudes at multiples of 1/duration, of samples without their mean under a Hann
/// window.
Curve spectrumOf(const Eigen::VectorXd& values, double interval_s, const std::string& name)
{
    const Eigen::Index size = std::min(values.size(), kMostOfSpectrum);
    const double mean = values.head(size).mean();
    const double step_Hz = 1.0 / (interval_s * static_cast<double>(size));
    const auto count =
        std::min(size / 2, static_cast<Eigen::Index>(std::floor(kMostSpectrum_Hz / step_Hz)) + 1);
    Eigen::VectorXd frequency_Hz(std::max<Eigen::Index>(count, 1));
    Eigen::VectorXd amplitude = Eigen::VectorXd::Zero(frequency_Hz.size());
    for (Eigen::Index k = 0; k < frequency_Hz.size(); ++k)
    {
        frequency_Hz[k] = step_Hz * static_cast<double>(k);
        std::complex<double> sum = 0.0;
        for (Eigen::Index n = 0; n < size; ++n)
        {
            const double turns = static_cast<double>(n) / static_cast<double>(size);
            const double window = 0.5 - 0.5 * std::cos(base::kTwoPi * turns);
            sum += window * (values[n] - mean) *
                   std::polar(1.0, -base::kTwoPi * static_cast<double>(k) * turns);
        }
        amplitude[k] = 4.0 * std::abs(sum) / static_cast<double>(size);
    }
    return curveOf(frequency_Hz, amplitude, name);
}

CurvePanel panel(const std::string& xName, const std::string& yName, std::vector<Curve> curves)
{
    CurvePanel made;
    made.xName = xName;
    made.yName = yName;
    made.curves = std::move(curves);
    return made;
}

} // namespace

std::string drawSensation(const std::string& path,
                          const std::string& title,
                          const std::vector<TimedSample>& samples)
{
    const auto count = static_cast<Eigen::Index>(samples.size());
    Eigen::VectorXd time_ms(count), x_mm(count), y_mm(count), z_mm(count), intensity(count);
    for (Eigen::Index k = 0; k < count; ++k)
    {
        const TimedSample& one = samples[static_cast<std::size_t>(k)];
        time_ms[k] = one.time_ms;
        x_mm[k] = one.sample.position_mm.x();
        y_mm[k] = one.sample.position_mm.y();
        z_mm[k] = one.sample.position_mm.z();
        intensity[k] = one.sample.intensity;
    }
    CurvePlot plot;
    plot.title = title;
    plot.panels.push_back(panel(
        "time (ms)",
        "place (mm)",
        {curveOf(time_ms, x_mm, "x"), curveOf(time_ms, y_mm, "y"), curveOf(time_ms, z_mm, "z")}));
    plot.panels.push_back(
        panel("time (ms)", "intensity", {curveOf(time_ms, intensity, "intensity")}));
    if (count > 1)
    {
        const double interval_s = 1e-3 * (time_ms[1] - time_ms[0]);
        plot.panels.push_back(
            panel("frequency (Hz)",
                  "amplitude (mm)",
                  {spectrumOf(x_mm, interval_s, "x"), spectrumOf(y_mm, interval_s, "y")}));
        plot.panels.push_back(panel("frequency (Hz)",
                                    "amplitude of the intensity",
                                    {spectrumOf(intensity, interval_s, "intensity")}));
    }
    return drawCurves(path, plot);
}

} // namespace midair::samples
