#include "haptics/propagation/PressureField.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PointChunks.h"
#include "haptics/propagation/PropagationMatrix.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace midair::haptics
{

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

namespace
{

// Fields restricted to the transducers that any of them drives.
struct ActiveFields
{
    TransducerArray array;
    std::vector<Eigen::VectorXcf> fields;
};

// Returns the transducers that any of the fields drives.
std::vector<Eigen::Index> driven(const TransducerArray& array,
                                 const std::vector<Eigen::VectorXcf>& fields)
{
    std::vector<Eigen::Index> kept;
    kept.reserve(static_cast<std::size_t>(array.size()));
    for (Eigen::Index i = 0; i < array.size(); ++i)
        if (std::any_of(fields.begin(),
                        fields.end(),
                        [i](const Eigen::VectorXcf& q)
                        { return q[i] != std::complex<float>(0.0f, 0.0f); }))
            kept.push_back(i);
    return kept;
}

// Keeps only these, because most of the cost is one entry of G per point and transducer.
ActiveFields activePart(const TransducerArray& array,
                        const std::vector<Eigen::VectorXcf>& fields,
                        const std::vector<Eigen::Index>& kept)
{
    ActiveFields active;
    TransducerArray& part = active.array;
    part.frequency_Hz = array.frequency_Hz;
    part.sourceAmplitude_Pa_m = array.sourceAmplitude_Pa_m;
    part.directivity = array.directivity;
    part.positions = array.positions(Eigen::all, kept);
    part.normals = array.normals(Eigen::all, kept);
    if (array.phaseOffset_rad.size() > 0) part.phaseOffset_rad = array.phaseOffset_rad(kept);
    if (array.gain.size() > 0) part.gain = array.gain(kept);
    part.reflectors = array.reflectors;
    part.board.resize(kept.size(), 0);
    for (const Eigen::VectorXcf& q : fields)
        active.fields.emplace_back(q(kept));
    return active;
}

// A matrix of a few rows, bound to an array and its air. Each thread keeps the last two:
// consecutive requests use the same array, with and without shadows, and binding takes as long as
// dozens of rows.
PropagationMatrix& boundTo(const TransducerArray& array, const Medium& medium)
{
    thread_local std::array<PropagationMatrix, 2> kept;
    thread_local std::size_t oldest = 0;
    for (PropagationMatrix& one : kept)
        if (one.isBoundTo(array, medium)) return one;
    PropagationMatrix& other = kept.at(oldest);
    oldest = 1 - oldest;
    other.bind(array, medium);
    return other;
}

// For each field the real parts, then the imaginary ones, padded with zeros.
base::AlignedBuffer<float> inLanes(const PropagationMatrix& G,
                                   const std::vector<Eigen::VectorXcf>& fields)
{
    const auto padded = static_cast<std::size_t>(G.paddedTransducers());
    base::AlignedBuffer<float> q;
    q.reserve(2 * fields.size() * padded);
    for (std::size_t k = 0; k < fields.size(); ++k)
        for (std::size_t lane = 0; lane < G.order().size(); ++lane)
        {
            q[2 * k * padded + lane] = fields[k][G.order()[lane]].real();
            q[(2 * k + 1) * padded + lane] = fields[k][G.order()[lane]].imag();
        }
    return q;
}

} // namespace

Eigen::MatrixXcf pressuresAt(const Eigen::Matrix3Xd& points,
                             const TransducerArray& array,
                             const Medium& medium,
                             const std::vector<Eigen::VectorXcf>& fields,
                             int threads,
                             const base::StopToken& stop)
{
    for (const Eigen::VectorXcf& q : fields)
        checkActivations(array, q);
    const Eigen::Index n = points.cols();
    const std::size_t K = fields.size();
    Eigen::MatrixXcf pressure = Eigen::MatrixXcf::Zero(n, static_cast<Eigen::Index>(K));
    const std::vector<Eigen::Index> kept = driven(array, fields);
    if (n == 0 || kept.empty()) return pressure;
    const bool isWhole = static_cast<int>(kept.size()) == array.size();
    ActiveFields active;
    if (!isWhole) active = activePart(array, fields, kept);
    const TransducerArray& used = isWhole ? array : active.array;
    const std::vector<Eigen::VectorXcf>& usedFields = isWhole ? fields : active.fields;

    PointChunks chunks(n, stop);
    const auto work = [&]
    {
        // Rows of one chunk of points, summed while they are still cached.
        PropagationMatrix& G = boundTo(used, medium);
        const auto padded = static_cast<std::size_t>(G.paddedTransducers());
        const base::AlignedBuffer<float> q = inLanes(G, usedFields);
        std::array<int, PointChunks::kAtOnce> rows{};
        std::array<double, PointChunks::kAtOnce> sums{};
        std::iota(rows.begin(), rows.end(), 0);
        using Sums = std::array<float, 2 * PointChunks::kAtOnce>;
        std::vector<Sums> p(K);
        for (Eigen::Index begin = 0, count = 0; chunks.take(begin, count);)
        {
            G.resize(static_cast<int>(count));
            for (int l = 0; l < static_cast<int>(count); ++l)
                G.setPoint(l, points.col(begin + l));
            std::fill(p.begin(), p.end(), Sums{});
            for (int b = 0; b < G.blocks(); ++b)
            {
                G.buildRows(b, rows.data(), static_cast<int>(count), sums.data());
                for (std::size_t k = 0; k < K; ++k)
                    G.forward(b,
                              q.data() + 2 * k * padded,
                              q.data() + (2 * k + 1) * padded,
                              p[k].data(),
                              p[k].data() + PointChunks::kAtOnce);
            }
            const auto unit_Pa = static_cast<float>(G.unit_Pa());
            for (std::size_t k = 0; k < K; ++k)
                for (Eigen::Index l = 0; l < count; ++l)
                    pressure(begin + l, static_cast<Eigen::Index>(k)) = {
                        unit_Pa * p[k][static_cast<std::size_t>(l)],
                        unit_Pa * p[k][static_cast<std::size_t>(l + PointChunks::kAtOnce)]};
        }
    };
    chunks.run(threads, work);
    return pressure;
}

Eigen::VectorXcf pressureAt(const Eigen::Matrix3Xd& points,
                            const TransducerArray& array,
                            const Medium& medium,
                            const Eigen::VectorXcf& activations,
                            int threads,
                            const base::StopToken& stop)
{
    return pressuresAt(points, array, medium, {activations}, threads, stop);
}

Eigen::VectorXd meanSquarePressure(const Eigen::Matrix3Xd& points,
                                   const TransducerArray& array,
                                   const Medium& medium,
                                   const std::vector<Eigen::VectorXcf>& fields,
                                   int threads,
                                   const base::StopToken& stop)
{
    if (fields.empty())
        throw base::InputError("the cycle has no fields; there must be at least one");
    return pressuresAt(points, array, medium, fields, threads, stop)
        .cast<std::complex<double>>()
        .cwiseAbs2()
        .rowwise()
        .mean();
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
