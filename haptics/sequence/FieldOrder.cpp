#include "haptics/sequence/FieldOrder.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

float onLevel(float angle, int levels)
{
    if (levels <= 0) return angle;
    const float step = static_cast<float>(base::kTwoPi) / static_cast<float>(levels);
    return step * std::round(angle / step);
}

} // namespace

CycleSteps cycleSteps(const std::vector<Eigen::VectorXcf>& cycle)
{
    CycleSteps steps;
    double power = 0.0;
    for (std::size_t k = 0; k < cycle.size(); ++k)
    {
        const Eigen::VectorXcf& from = cycle[k];
        const Eigen::VectorXcf& to = cycle[(k + 1) % cycle.size()];
        for (Eigen::Index i = 0; i < from.size(); ++i)
        {
            const double step = std::fabs(std::arg(to[i] * std::conj(from[i])));
            steps.meanPhaseStep_rad += step / static_cast<double>(from.size() * cycle.size());
            steps.largestPhaseStep_rad = std::max(steps.largestPhaseStep_rad, step);
        }
        steps.driveChange += (to - from).squaredNorm();
        power += to.squaredNorm();
    }
    steps.driveChange = power > 0.0 ? steps.driveChange / power : 0.0;
    return steps;
}

std::vector<int> orderFields(std::vector<Eigen::VectorXcf>& fields)
{
    const std::size_t K = fields.size();
    std::vector<int> way(K);
    std::iota(way.begin(), way.end(), 0);
    if (K < 4) return way; // up to three fields form the same cycle in any order
    Eigen::MatrixXd near(K, K);
    for (std::size_t k = 0; k < K; ++k)
        for (std::size_t l = 0; l < K; ++l)
            near(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) =
                std::abs(fields[k].dot(fields[l]));
    const auto at = [&near](int k, int l) { return near(k, l); };
    for (std::size_t k = 1; k + 1 < K; ++k)
        for (std::size_t l = k + 1; l < K; ++l)
            if (at(way[k - 1], way[l]) > at(way[k - 1], way[k])) std::swap(way[k], way[l]);
    for (bool changed = true; changed;)
    {
        changed = false;
        for (std::size_t k = 1; k + 1 < K; ++k)
            for (std::size_t l = k + 1; l < K; ++l)
            {
                const int before = way[k - 1], after = way[(l + 1) % K];
                const double gain =
                    at(before, way[l]) + at(way[k], after) - at(before, way[k]) - at(way[l], after);
                if (!(gain > 1e-6 * near(0, 0))) continue;
                std::reverse(way.begin() + static_cast<std::ptrdiff_t>(k),
                             way.begin() + static_cast<std::ptrdiff_t>(l) + 1);
                changed = true;
            }
    }
    std::vector<Eigen::VectorXcf> ordered(K);
    for (std::size_t k = 0; k < K; ++k)
        ordered[k].swap(fields[static_cast<std::size_t>(way[k])]);
    fields.swap(ordered);
    return way;
}

void alignField(Eigen::VectorXcf& q, const Eigen::VectorXcf& last, const DriveResolution& drive)
{
    if (q.size() != last.size()) return;
    const float angle = std::arg(q.dot(last));
    q *= std::polar(1.0f, onLevel(angle, drive.phaseLevels));
}

void alignFields(std::vector<Eigen::VectorXcf>& fields, const DriveResolution& drive)
{
    const std::size_t K = fields.size();
    if (K < 2) return;
    for (std::size_t k = 1; k < K; ++k)
        alignField(fields[k], fields[k - 1], drive);
    // Phase of the last relative to the first.
    const float left = std::arg(fields[0].dot(fields[K - 1]));
    for (std::size_t k = 1; k < K; ++k)
    {
        const float share = -left * static_cast<float>(k) / static_cast<float>(K);
        fields[k] *= std::polar(1.0f, onLevel(share, drive.phaseLevels));
    }
}

std::vector<Eigen::VectorXcf>
smoothedFields(const std::vector<Eigen::VectorXcf>& fields, int steps, const DriveResolution& drive)
{
    if (steps < 0)
        throw base::InputError(
            fmt::format("field cycle: {} steps between fields; there must be at least 0", steps));
    std::vector<Eigen::VectorXcf> result;
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        const Eigen::VectorXcf& from = fields[k];
        const Eigen::VectorXcf& to = fields[(k + 1) % fields.size()];
        result.push_back(from);
        for (int s = 1; s <= steps && fields.size() > 1; ++s)
        {
            const float share = static_cast<float>(s) / static_cast<float>(steps + 1);
            Eigen::VectorXcf between(from.size());
            for (Eigen::Index i = 0; i < from.size(); ++i)
            {
                const float amplitude =
                    (1.0f - share) * std::abs(from[i]) + share * std::abs(to[i]);
                const float angle =
                    std::arg(from[i]) + share * std::arg(to[i] * std::conj(from[i]));
                between[i] = std::polar(playableAmplitude(drive.amplitudeLevels, amplitude),
                                        onLevel(angle, drive.phaseLevels));
            }
            result.push_back(std::move(between));
        }
    }
    return result;
}

void roundPhases(Eigen::VectorXcf& q, const DriveResolution& drive)
{
    if (drive.phaseLevels <= 0) return;
    for (std::complex<float>& one : q)
        one = std::polar(std::abs(one), onLevel(std::arg(one), drive.phaseLevels));
}

void scaleField(Eigen::VectorXcf& q, float share, const DriveResolution& drive)
{
    Eigen::VectorXf amplitudes = (share * q.cwiseAbs()).cwiseMin(1.0f);
    roundAmplitudes(drive.amplitudeLevels, static_cast<int>(q.size()), amplitudes.data());
    for (Eigen::Index i = 0; i < q.size(); ++i)
    {
        const float amplitude = std::abs(q[i]);
        if (amplitude > 0.0f) q[i] *= amplitudes[i] / amplitude;
    }
}

} // namespace midair::haptics
