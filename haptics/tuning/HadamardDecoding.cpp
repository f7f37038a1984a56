#include "haptics/tuning/HadamardDecoding.h"

#include <Eigen/QR>

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Fast Walsh-Hadamard transform in place, in natural order: n log2 n additions.
void transform(Eigen::VectorXcd& values)
{
    for (Eigen::Index half = 1; half < values.size(); half *= 2)
        for (Eigen::Index block = 0; block < values.size(); block += 2 * half)
            for (Eigen::Index k = block; k < block + half; ++k)
            {
                const std::complex<double> a = values[k], b = values[k + half];
                values[k] = a + b;
                values[k + half] = a - b;
            }
}

double signOf(int row, int column)
{
    return __builtin_parity(static_cast<unsigned>(row) & static_cast<unsigned>(column)) ? -1.0
                                                                                        : 1.0;
}

void fillIn(Eigen::VectorXcd& values,
            const std::vector<int>& missing,
            const std::vector<int>& unused)
{
    Eigen::VectorXcd columns = values;
    transform(columns);
    const auto count = static_cast<Eigen::Index>(missing.size());
    Eigen::MatrixXd signs(static_cast<Eigen::Index>(unused.size()), count);
    Eigen::MatrixX2d heard(signs.rows(), 2);
    for (Eigen::Index u = 0; u < signs.rows(); ++u)
    {
        const int column = unused[static_cast<std::size_t>(u)];
        heard.row(u) << columns[column].real(), columns[column].imag();
        for (Eigen::Index k = 0; k < count; ++k)
            signs(u, k) = signOf(missing[static_cast<std::size_t>(k)], column);
    }
    const Eigen::MatrixX2d found = signs.colPivHouseholderQr().solve(-heard);
    for (Eigen::Index k = 0; k < count; ++k)
        values[missing[static_cast<std::size_t>(k)]] = {found(k, 0), found(k, 1)};
}

} // namespace

void decodeHadamard(const TuningPlan& plan,
                    const TuningReadings& readings,
                    int place,
                    TuningResponses& to)
{
    const int n = plan.order();
    Eigen::VectorXcd values = Eigen::VectorXcd::Zero(n);
    std::vector<bool> isRead(static_cast<std::size_t>(n), false);
    for (int k = 0; k < plan.size(); ++k)
    {
        const TuningRow& row = plan.rows[static_cast<std::size_t>(k)];
        const std::complex<double> value = readings.values[k];
        if (row.place != place || row.element >= n || !std::isfinite(value.real())) continue;
        values[row.element] = value;
        isRead[static_cast<std::size_t>(row.element)] = true;
    }
    std::vector<int> missing, unused;
    for (int r = 0; r < n; ++r)
        if (!isRead[static_cast<std::size_t>(r)]) missing.push_back(r);
    for (int c = 1; c < n; ++c)
        if (c > plan.transducers || plan.isOff(c - 1)) unused.push_back(c);
    if (2 * missing.size() > unused.size())
    {
        to.refusal =
            fmt::format("{} of the {} rows of place {} have no reading ({}); at most {} can "
                        "be filled in, so measure these again",
                        missing.size(),
                        n,
                        place,
                        rangesText(missing),
                        unused.size() / 2);
        return;
    }
    if (!missing.empty())
    {
        fillIn(values, missing, unused);
        to.notes.push_back(fmt::format(
            "{} rows of place {} without a reading follow from the others", missing.size(), place));
    }
    transform(values);
    values /= double(n);
    double square = 0.0;
    for (const int column : unused)
        square += std::norm(values[column]);
    const std::size_t free = unused.size() - missing.size();
    to.noise[place] = free > 0 ? std::sqrt(square / double(free)) : 0.0;
    for (int i = 0; i < plan.transducers; ++i)
        if (!plan.isOff(i)) to.y(place, i) = values[i + 1];
}

} // namespace midair::haptics
