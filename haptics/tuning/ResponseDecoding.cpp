#include "haptics/tuning/ResponseDecoding.h"

#include "haptics/base/Percentile.h"

#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
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

// A reference that is weaker than this beside a single transducer measures badly.
constexpr double kWeakest = 0.15;
// Median of |I_0 + I_180 - I_90 - I_270| / (4 |S| |y|): 0.01 to 0.1 of noise.
constexpr double kMostMismatch = 0.2;

/// A reference, named by its first transducer.
struct Reference
{
    double aloneSum = 0.0; ///< of squared levels, silence taken off
    int alone = 0;
    std::map<int, std::array<double, 4>> quarters; ///< by transducer; NaN: no reading
    int step = 0;

    double square() const { return alone > 0 ? std::max(0.0, aloneSum / alone) : 0.0; }
    bool contains(int i, int first) const { return i >= first && (i - first) % step == 0; }
};

double silenceOf(const TuningPlan& plan, const TuningReadings& readings, int place)
{
    double sum = 0.0;
    int count = 0;
    for (int k = 0; k < plan.size(); ++k)
    {
        const TuningRow& row = plan.rows[static_cast<std::size_t>(k)];
        if (row.place != place || row.dutyLevel > 0 || row.referenceDutyLevel > 0) continue;
        if (!std::isfinite(readings.values[k].real())) continue;
        sum += std::norm(readings.values[k]);
        ++count;
    }
    return count > 0 ? sum / count : 0.0;
}

std::map<int, Reference>
gather(const TuningPlan& plan, const TuningReadings& readings, int place, double silence)
{
    std::map<int, Reference> references;
    for (int k = 0; k < plan.size(); ++k)
    {
        const TuningRow& row = plan.rows[static_cast<std::size_t>(k)];
        if (row.place != place || row.referenceDutyLevel == 0) continue;
        Reference& reference = references[row.referenceFirst];
        reference.step = row.referenceStep;
        const double square = std::norm(readings.values[k]) - silence;
        if (row.dutyLevel > 0)
        {
            const double none = std::nan("");
            reference.quarters
                .try_emplace(row.element, std::array<double, 4>{none, none, none, none})
                .first->second[static_cast<std::size_t>(row.phaseLevel / 64)] = square;
        }
        else if (std::isfinite(square))
        {
            reference.aloneSum += square;
            ++reference.alone;
        }
    }
    return references;
}

/// Returns y conj(S); NaN where more than one of the four is missing. Adds the mismatch of four.
std::complex<double> productOf(std::array<double, 4> I, std::vector<double>& mismatch, int& filled)
{
    const auto isMissing = [](double square) { return !std::isfinite(square); };
    const auto missing = std::count_if(I.begin(), I.end(), isMissing);
    if (missing > 1) return {std::nan(""), std::nan("")};
    if (missing == 1)
    {
        const auto at = std::find_if(I.begin(), I.end(), isMissing) - I.begin();
        const double other = I[static_cast<std::size_t>((at + 2) % 4)];
        I[static_cast<std::size_t>(at)] = I[static_cast<std::size_t>((at + 1) % 4)] +
                                          I[static_cast<std::size_t>((at + 3) % 4)] - other;
        ++filled;
    }
    const std::complex<double> product(0.25 * (I[0] - I[2]), 0.25 * (I[3] - I[1]));
    if (missing == 0) mismatch.push_back(std::abs(I[0] + I[2] - I[1] - I[3]));
    return product;
}

std::string weakRefusal(int place, double reference, double median)
{
    if (reference > kWeakest * median) return {};
    return fmt::format(
        "the reference transducers cancel each other at place {}: {:.3g} beside "
        "{:.3g} of one transducer; move the microphone by a centimetre and plan anew",
        place,
        reference,
        median);
}

/// Both references, with which the transducers are put together.
class Joined
{
public:
    Joined(const TuningPlan& plan, int place, std::map<int, Reference>& references) :
        _plan(plan),
        _place(place),
        _first(references.begin()->second),
        _second(std::next(references.begin())->second),
        _secondFirst(std::next(references.begin())->first)
    {
    }

    void decode(TuningResponses& to, double silence)
    {
        std::vector<double> mismatch, amplitudes;
        int filled = 0;
        const double size = std::sqrt(_first.square());
        for (const auto& [i, quarters] : _first.quarters)
        {
            to.y(_place, i) = productOf(quarters, mismatch, filled) / size;
            if (std::isfinite(to.y(_place, i).real()))
                amplitudes.push_back(std::abs(to.y(_place, i)));
        }
        const double median = base::percentile(amplitudes, 0.5);
        const double typical = base::percentile(mismatch, 0.5) / (4.0 * size * median);
        to.noise[_place] = std::sqrt(0.5 * silence) * (size + median) / size;
        to.refusal = weakRefusal(_place, size, median);
        // Noise alone gives sigma/|y| of mismatch.
        if (to.refusal.empty() && typical > kMostMismatch + 3.0 * std::sqrt(silence) / median)
            to.refusal =
                fmt::format("the levels at place {} don't add up as they must ({:.0f} % off): "
                            "the microphone clips, or its levels aren't linear (dB?)",
                            _place,
                            100.0 * typical);
        if (!to.refusal.empty()) return;
        decodeSecond(to, size, mismatch, filled);
        if (filled > 0)
            to.notes.push_back(fmt::format(
                "{} transducers at place {} with one of four readings missing follow from three",
                filled,
                _place));
    }

private:
    // Those of the first reference, measured beside the second one.
    void decodeSecond(TuningResponses& to, double size, std::vector<double>& mismatch, int& filled)
    {
        std::complex<double> X = 0.0;
        for (int j = 0; j < _plan.transducers; ++j)
            if (_second.contains(j, _secondFirst) && !_plan.isOff(j)) X += to.y(_place, j) * size;
        const double square = _second.square();
        for (const auto& [i, quarters] : _second.quarters)
            to.y(_place, i) = productOf(quarters, mismatch, filled) * X / (square * size);
        if (!std::isfinite(X.real()) || !(square > 0.0))
            to.notes.push_back(
                fmt::format("the second reference at place {} isn't measured, so that "
                            "the {} transducers of the first are not",
                            _place,
                            _second.quarters.size()));
    }

    const TuningPlan& _plan;
    const int _place;
    Reference& _first;
    Reference& _second;
    const int _secondFirst;
};

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

void decodeLevels(const TuningPlan& plan,
                  const TuningReadings& readings,
                  int place,
                  TuningResponses& to)
{
    const double silence = silenceOf(plan, readings, place);
    std::map<int, Reference> references = gather(plan, readings, place, silence);
    if (references.size() != 2 || !(references.begin()->second.square() > 0.0))
    {
        to.refusal =
            fmt::format("the microphone hears nothing of the reference alone at place {}, or "
                        "its rows have no reading",
                        place);
        return;
    }
    Joined(plan, place, references).decode(to, silence);
}

} // namespace midair::haptics
