#include "haptics/sequence/CycleEqualizer.h"

#include <cmath>
#include <complex>
#include <vector>

namespace midair::haptics
{

// Sets the sums of |p|^2, and w = p.
void CycleEqualizer::sumSteady()
{
    _places.intensity.setZero();
    for (Field& field : _sounding)
    {
        for (Eigen::Index l = 0; l < _places.intensity.size(); ++l)
            _places.intensity[l] += std::norm(field.p.at(static_cast<std::size_t>(l)));
        copy(field.p, field.w, static_cast<std::size_t>(_matrix.points()));
    }
}

// Sets the sums of p* M p, and w = M p. Most fields are too far apart to overlap.
void CycleEqualizer::sumRinging()
{
    constexpr float kNothing = 1e-6f; // of the mean
    const auto K = static_cast<std::size_t>(_overlaps.size());
    std::vector<std::size_t> apart;
    for (std::size_t d = 0; d < K; ++d)
        if (std::abs(_overlaps[static_cast<Eigen::Index>(d)]) > kNothing) apart.push_back(d);
    std::vector<std::complex<float>> p(K); // silent fields are 0
    for (Eigen::Index row = 0; row < _places.intensity.size(); ++row)
    {
        const auto l = static_cast<std::size_t>(row);
        for (const Field& field : _sounding)
            p[field.index] = field.p.at(l);
        float sum = 0.0f;
        for (Field& field : _sounding)
        {
            std::complex<float> w = 0.0f;
            for (const std::size_t d : apart)
                w += _overlaps[static_cast<Eigen::Index>(d)] * p[(field.index + d) % K];
            field.w.set(l, w);
            sum += std::real(std::conj(field.p.at(l)) * w);
        }
        _places.intensity[row] = sum;
    }
}

// Sets the intensities, their mean and variation from p; returns f.
double CycleEqualizer::evaluate()
{
    if (_overlaps.size() > 0)
        sumRinging();
    else
        sumSteady();
    _places.intensity /= static_cast<float>(_fields.size());
    const Eigen::ArrayXd weight = _places.targets2.cast<double>();
    const Eigen::ArrayXd ratio = _places.intensity.cast<double>().array() / weight;
    const double all = weight.sum();
    _evenness.mean = (weight * ratio).sum() / all;
    _evenness.variation =
        _evenness.mean > 0.0
            ? std::sqrt((weight * (ratio - _evenness.mean).square()).sum() / all) / _evenness.mean
            : 0.0;
    if (!_descent.isStarted)
        _evenness.goal =
            (_overlaps.size() > 0 ? _options.ringingRaise : _options.raise) * _evenness.mean;
    // About the mean, as the two parts are known apart: ratio/goal - 1 = (ratio - mean)/goal + ..
    const double spread = _evenness.variation * _evenness.mean / _evenness.goal,
                 off = _evenness.mean / _evenness.goal - 1.0;
    return spread * spread + off * off;
}

} // namespace midair::haptics
