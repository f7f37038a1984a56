#include "haptics/sequence/CycleVibration.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/FingertipVibration.h"
#include "haptics/propagation/RingingMean.h"

namespace midair::haptics
{

CycleVibration::CycleVibration(const Eigen::Matrix3Xd& places,
                               int fields,
                               double step_s,
                               double ringing_s) :
    _pads(fingertipPads(places).cast<float>())
{
    constexpr float kNothing = 1e-6f; // of the mean
    const auto K = static_cast<std::size_t>(fields);
    const int waves = feltWaves(fields, step_s);
    std::vector<Eigen::VectorXcf> overlaps;
    for (int h = 1; h <= waves; ++h)
        overlaps.push_back(waveOverlaps(fields, step_s, ringing_s, h).cast<std::complex<float>>());
    for (std::size_t d = 0; d < K; ++d)
    {
        float most = 0.0f;
        for (const Eigen::VectorXcf& M : overlaps)
            most = std::max(most, std::abs(M[static_cast<Eigen::Index>(d)]));
        if (most > kNothing) _apart.push_back(d);
    }
    for (int h = 1; h <= waves; ++h)
    {
        Wave& wave = _waves.emplace_back();
        for (const std::size_t d : _apart)
            wave.overlaps.push_back(
                overlaps[static_cast<std::size_t>(h - 1)][static_cast<Eigen::Index>(d)]);
        for (std::size_t k = 0; k < K; ++k)
            wave.turns.emplace_back(std::polar(
                1.0, -base::kTwoPi * h * static_cast<double>(k) / static_cast<double>(K)));
        const double s = skinSensitivity(h / (fields * step_s));
        wave.sensitivity2 = static_cast<float>(s * s);
    }
    _re.setZero(places.cols(), waves);
    _im.setZero(places.cols(), waves);
}

// A_h = 2/K sum_k z^{h k} sum_d M_d conj(p_k) p_{k + d}.
void CycleVibration::set(Eigen::Index l, const Pressures& p)
{
    const std::size_t K = p.size();
    for (std::size_t h = 0; h < _waves.size(); ++h)
    {
        const Wave& wave = _waves[h];
        std::complex<float> sum = 0.0f;
        for (std::size_t k = 0; k < K; ++k)
        {
            std::complex<float> next = 0.0f;
            for (std::size_t a = 0; a < _apart.size(); ++a)
                next += wave.overlaps[a] * p[(k + _apart[a]) % K];
            sum += wave.turns[k] * std::conj(p[k]) * next;
        }
        sum *= 2.0f / static_cast<float>(K);
        _re(l, static_cast<Eigen::Index>(h)) = sum.real();
        _im(l, static_cast<Eigen::Index>(h)) = sum.imag();
    }
}

// V = 1/(2 N mean^2) sum_pads sum_h s_h^2 |D_h|^2, D = P A, so dV = Re sum_l sum_h conj(B_lh) dA_lh
// with B = 1/(N mean^2) P^T s^2 D. A_h contains 2/K times what addTo() differentiates.
double CycleVibration::squared(double mean)
{
    if (isEmpty() || _pads.rows() == 0) return 0.0;
    const auto K = static_cast<float>(_waves.front().turns.size());
    const double scale = 1.0 / (static_cast<double>(_pads.rows()) * mean * mean);
    double sum = 0.0;
    for (Eigen::MatrixXf* part : {&_re, &_im})
    {
        Eigen::MatrixXf D = _pads * *part;
        for (Eigen::Index h = 0; h < D.cols(); ++h)
        {
            const float s2 = _waves[static_cast<std::size_t>(h)].sensitivity2;
            sum += 0.5 * scale * static_cast<double>(s2 * D.col(h).squaredNorm());
            D.col(h) *= 2.0f / K * s2 * static_cast<float>(scale);
        }
        *part = _pads.transpose() * D;
    }
    return sum;
}

// u_k = sum_h conj(B_h) z^{h k} sum_d M_d p_{k + d} + B_h z^{-h k} sum_d z^{h d} conj(M_d) p_{k -
// d}.
void CycleVibration::addTo(Eigen::Index l, float factor, const Pressures& p, Pressures& w) const
{
    const std::size_t K = p.size();
    for (std::size_t h = 0; h < _waves.size(); ++h)
    {
        const Wave& wave = _waves[h];
        const auto column = static_cast<Eigen::Index>(h);
        const std::complex<float> B(factor * _re(l, column), factor * _im(l, column));
        for (std::size_t k = 0; k < K; ++k)
        {
            std::complex<float> next = 0.0f, before = 0.0f;
            for (std::size_t a = 0; a < _apart.size(); ++a)
            {
                const std::size_t d = _apart[a];
                next += wave.overlaps[a] * p[(k + d) % K];
                before += wave.turns[d] * std::conj(wave.overlaps[a]) * p[(k + K - d) % K];
            }
            w[k] += std::conj(B) * wave.turns[k] * next + B * std::conj(wave.turns[k]) * before;
        }
    }
}

} // namespace midair::haptics
