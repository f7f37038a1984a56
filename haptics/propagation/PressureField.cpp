#include "haptics/propagation/PressureField.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr Eigen::Index kPointsAtOnce = 8;

// Keeps only driven transducers, as most of the cost is one entry of G for each point and
// transducer.
TransducerArray activePart(const TransducerArray& array,
                           const Eigen::VectorXcf& activations,
                           Eigen::VectorXcf& active)
{
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < activations.size(); ++i)
        if (activations[i] != std::complex<float>(0.0f, 0.0f)) kept.push_back(i);

    TransducerArray part;
    part.frequency_Hz = array.frequency_Hz;
    part.sourceAmplitude_Pa_m = array.sourceAmplitude_Pa_m;
    part.directivity = array.directivity;
    part.positions = array.positions(Eigen::all, kept);
    part.normals = array.normals(Eigen::all, kept);
    if (array.phaseOffset_rad.size() > 0) part.phaseOffset_rad = array.phaseOffset_rad(kept);
    if (array.gain.size() > 0) part.gain = array.gain(kept);
    part.board.resize(kept.size(), 0);
    active = activations(kept);
    return part;
}

} // namespace

Eigen::Matrix3Xd FieldGrid::points() const
{
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(columns) * rows);
    const double columnStep = columns > 1 ? 1.0 / (columns - 1) : 0.0;
    const double rowStep = rows > 1 ? 1.0 / (rows - 1) : 0.0;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            points.col(static_cast<Eigen::Index>(row) * columns + column) =
                corner + column * columnStep * u + row * rowStep * v;
    return points;
}

Eigen::VectorXcf pressureAt(const Eigen::Matrix3Xd& points,
                            const TransducerArray& array,
                            const Medium& medium,
                            const Eigen::VectorXcf& activations,
                            int threads,
                            const base::StopToken& stop)
{
    if (activations.size() != array.size())
        throw base::InputError(fmt::format(
            "activations are {}; there must be one for each of the array's {} transducers",
            activations.size(),
            array.size()));
    const Eigen::Index n = points.cols();
    Eigen::VectorXcf pressure = Eigen::VectorXcf::Zero(n);
    Eigen::VectorXcf q;
    const TransducerArray active = activePart(array, activations, q);
    if (n == 0 || active.size() == 0) return pressure;

    std::atomic<Eigen::Index> next{0};
    const auto work = [&]
    {
        // Rows of one chunk of points; they are summed while they are still in the cache.
        PropagationMatrix G;
        G.bind(active, medium);
        base::AlignedBuffer<float> qRe; // padded with zeros
        base::AlignedBuffer<float> qIm;
        qRe.reserve(static_cast<std::size_t>(G.paddedTransducers()));
        qIm.reserve(static_cast<std::size_t>(G.paddedTransducers()));
        for (std::size_t lane = 0; lane < G.order().size(); ++lane)
        {
            qRe[lane] = q[G.order()[lane]].real();
            qIm[lane] = q[G.order()[lane]].imag();
        }
        std::array<int, kPointsAtOnce> rows{};
        std::array<double, kPointsAtOnce> sums{};
        std::iota(rows.begin(), rows.end(), 0);
        for (Eigen::Index begin = next.fetch_add(kPointsAtOnce); begin < n;
             begin = next.fetch_add(kPointsAtOnce))
        {
            if (stop.requested()) return;
            const Eigen::Index count = std::min(kPointsAtOnce, n - begin);
            G.resize(static_cast<int>(count));
            for (int l = 0; l < static_cast<int>(count); ++l)
                G.setPoint(l, points.col(begin + l));
            std::array<float, kPointsAtOnce> pRe{};
            std::array<float, kPointsAtOnce> pIm{};
            for (int b = 0; b < G.blocks(); ++b)
            {
                G.buildRows(b, rows.data(), static_cast<int>(count), sums.data());
                G.forward(b, qRe.data(), qIm.data(), pRe.data(), pIm.data());
            }
            for (Eigen::Index l = 0; l < count; ++l)
                pressure[begin + l] = {pRe[static_cast<std::size_t>(l)],
                                       pIm[static_cast<std::size_t>(l)]};
        }
    };
    const auto chunks = (n + kPointsAtOnce - 1) / kPointsAtOnce;
    std::vector<std::thread> helpers;
    for (Eigen::Index t = 1; t < std::min<Eigen::Index>(threads, chunks); ++t)
        helpers.emplace_back(work);
    work();
    for (std::thread& helper : helpers)
        helper.join();
    stop.throwIfRequested();
    return pressure;
}

double radiationPressure(double pressure_Pa, const Medium& medium, double alpha)
{
    const double c = medium.soundSpeed();
    return alpha * 0.5 * pressure_Pa * pressure_Pa / (medium.density() * c * c);
}

double radiationForce(double pressure_Pa, double area_m2, const Medium& medium, double alpha)
{
    return radiationPressure(pressure_Pa, medium, alpha) * area_m2;
}

} // namespace midair::haptics
