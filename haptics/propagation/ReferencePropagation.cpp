#include "haptics/propagation/ReferencePropagation.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace midair::haptics
{

Eigen::MatrixXcd referencePropagationMatrix(const Eigen::Matrix3Xd& points,
                                            const TransducerArray& array,
                                            const Medium& medium)
{
    const double k = base::kTwoPi / medium.wavelength(array.frequency_Hz);
    const double beta = medium.attenuation(array.frequency_Hz);
    const bool hasGain = array.gain.size() > 0;
    const bool hasPhaseOffset = array.phaseOffset_rad.size() > 0;

    Eigen::MatrixXcd G(points.cols(), array.size());
    for (Eigen::Index i = 0; i < G.cols(); ++i)
    {
        const double strength = array.sourceAmplitude_Pa_m * (hasGain ? array.gain[i] : 1.0);
        const double offset = hasPhaseOffset ? array.phaseOffset_rad[i] : 0.0;
        for (Eigen::Index l = 0; l < G.rows(); ++l)
        {
            const Eigen::Vector3d d = points.col(l) - array.positions.col(i);
            const double R = std::max(d.norm(), kNearestDistance_m);
            const double cosTheta = std::clamp(d.dot(array.normals.col(i)) / R, -1.0, 1.0);
            const double amplitude = strength * directivity(array.directivity, cosTheta) / R;
            G(l, i) = std::polar(amplitude * std::exp(-beta * R), offset - k * R);
        }
    }
    return G;
}

} // namespace midair::haptics
