#include "haptics/propagation/ReferencePropagation.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/Reflections.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace midair::haptics
{

namespace
{

// Calls take(l, entry, image) for each way from transducer  i to the points.
template<typename Take>
void walk(const Eigen::Matrix3Xd& points,
          Eigen::Index i,
          const TransducerArray& array,
          const Medium& medium,
          const Take& take)
{
    const double wavelength_m = medium.wavelength(array.frequency_Hz);
    const double k = base::kTwoPi / wavelength_m;
    const double beta = medium.attenuation(array.frequency_Hz);
    const double strength =
        array.sourceAmplitude_Pa_m * (array.gain.size() > 0 ? array.gain[i] : 1.0);
    const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
    const Eigen::Vector3d from = array.positions.col(i);
    const auto wave = [&](const Eigen::Vector3d& at)
    {
        const Eigen::Vector3d d = at - from;
        const double R = std::max(d.norm(), kNearestDistance_m);
        const double cosTheta = std::clamp(d.dot(array.normals.col(i)) / R, -1.0, 1.0);
        const double amplitude = strength * directivity(array.directivity, cosTheta) / R;
        return std::polar(amplitude * std::exp(-beta * R), offset - k * R);
    };
    for (Eigen::Index l = 0; l < points.cols(); ++l)
        forEachPath(array.reflectors,
                    from,
                    points.col(l),
                    wavelength_m,
                    wave,
                    [&](const std::complex<double>& entry, const Eigen::Vector3d& image)
                    { take(l, entry, image); });
}

} // namespace

Eigen::MatrixXcd referencePropagationMatrix(const Eigen::Matrix3Xd& points,
                                            const TransducerArray& array,
                                            const Medium& medium)
{
    Eigen::MatrixXcd G = Eigen::MatrixXcd::Zero(points.cols(), array.size());
    for (Eigen::Index i = 0; i < G.cols(); ++i)
        walk(points,
             i,
             array,
             medium,
             [&](Eigen::Index l, const std::complex<double>& entry, const Eigen::Vector3d&)
             { G(l, i) += entry; });
    return G;
}

std::vector<SoundPath>
referencePaths(const Eigen::Vector3d& point, const TransducerArray& array, const Medium& medium)
{
    std::vector<SoundPath> paths;
    for (int i = 0; i < array.size(); ++i)
        walk(point,
             i,
             array,
             medium,
             [&](Eigen::Index, const std::complex<double>& entry, const Eigen::Vector3d& image) {
                 paths.push_back({i, (image - array.positions.col(i)).norm(), entry});
             });
    return paths;
}

} // namespace midair::haptics
