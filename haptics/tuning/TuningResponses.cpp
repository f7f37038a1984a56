#include "haptics/tuning/TuningResponses.h"

#include "haptics/base/Percentile.h"

#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

// A reference weaker than this relative to a single transducer measures badly.
constexpr double kWeakest = 0.15;
// Median of |I_0 + I_180 - I_90 - I_270| / (4 |S| |y|): 0.01 to 0.1 due to noise.
constexpr double kMostMismatch = 0.2;

/// A reference, named by its first transducer.
struct Reference
{
    double aloneSum = 0.0; ///< of squared levels, minus silence
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

/// Returns y conj(S); NaN if more than one of the four is missing. Adds the mismatch of four.
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

/// Both references, with which the transducers are combined.
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
        // Noise alone gives a mismatch of sigma/|y|.
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
    // Those of the first reference, measured with the second one.
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

/// Separates transducers that played all at once. Row r of Sylvester's matrix of order n has the
/// sign (-1)^popcount(r & c) in column c, and transducer i plays column i + 1. The matrix is
/// symmetric, and its own inverse except for the factor n, so
///     n y_c = sum_r sign(r, c) Y_r.
/// Column 0 is leakage into every row; the columns after the last transducer contain only noise.
/// Missing rows are filled in so that these unused columns become 0, in the least-squares sense; if
/// more rows are missing than half of these columns, the place is refused.
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

/// Separates transducers by levels L only. With a reference S a transducer y plays at 0, 90, 180
/// and 270 degrees:
///     I_psi = |S + y e^{j psi}|^2,  y conj(S) = ((I_0 - I_180) + j (I_270 - I_90)) / 4,
/// and I_0 + I_180 = I_90 + I_270, which gives a missing one of the four, and detects a clipping
/// microphone. |S|^2 is the level of the reference alone. The transducers of the first reference A
/// are measured with a second one B, whose transducers were measured with A:
///     y conj(S_A) = y conj(S_B) X / |S_B|^2,  X = conj(S_A) S_B = sum of y_j conj(S_A) over B.
/// The result is y e^{-j arg S_A}. The mean square of silent rows is subtracted from each square.
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

constexpr double kNoResponse = std::numeric_limits<double>::quiet_NaN();
// A clipping microphone gives many readings near its limit. For transducers whose gains differ by 5
// % a few per mille are within 2 % of the loudest; for equal ones as many as are equally far away.
constexpr double kPlateau = 0.98;
constexpr double kPlateauShare = 0.08;
// The median of |noise| is 0.83 of its rms: less than this many times the rms is no signal.
constexpr double kHeard = 3.0;
constexpr int kLeastSilent = 4;

bool isKnown(const std::complex<double>& value)
{
    return std::isfinite(value.real());
}

void decodeSingle(const TuningPlan& plan,
                  const TuningReadings& readings,
                  int place,
                  TuningResponses& to)
{
    std::complex<double> leak = 0.0;
    double square = 0.0;
    int silent = 0;
    for (int k = 0; k < plan.size(); ++k)
    {
        const TuningRow& row = plan.rows[static_cast<std::size_t>(k)];
        const std::complex<double> value = readings.values[k];
        if (row.place != place || !isKnown(value)) continue;
        if (row.dutyLevel > 0)
            to.y(place, row.element) = value;
        else
        {
            leak += value;
            square += std::norm(value);
            ++silent;
        }
    }
    if (silent < kLeastSilent) return;
    leak /= double(silent);
    to.noise[place] = std::sqrt(std::max(0.0, square / silent - std::norm(leak)));
    to.y.row(place).array() -= leak;
}

std::vector<double> amplitudesOf(const Eigen::MatrixXcd& y, int place)
{
    std::vector<double> amplitudes;
    for (Eigen::Index i = 0; i < y.cols(); ++i)
        if (isKnown(y(place, i))) amplitudes.push_back(std::abs(y(place, i)));
    return amplitudes;
}

double shareNearTop(const std::vector<double>& levels)
{
    if (levels.size() < 20) return 0.0;
    const double edge = kPlateau * *std::max_element(levels.begin(), levels.end());
    return double(std::count_if(
               levels.begin(), levels.end(), [edge](double level) { return level >= edge; })) /
           double(levels.size());
}

// The share of a place's readings near the loudest, and that of equal transducers.
std::pair<double, double> plateauShares(const TuningPlan& plan,
                                        const TuningReadings& readings,
                                        const Eigen::MatrixXd& expected,
                                        int place)
{
    std::vector<double> loud, equal;
    for (int k = 0; k < plan.size(); ++k)
    {
        const TuningRow& row = plan.rows[static_cast<std::size_t>(k)];
        if (row.place != place || row.dutyLevel == 0 || !isKnown(readings.values[k])) continue;
        loud.push_back(std::abs(readings.values[k]));
        if (plan.method == TuningMethod::SINGLE) equal.push_back(expected(place, row.element));
    }
    return {shareNearTop(loud), shareNearTop(equal)};
}

std::string clipRefusal(const TuningPlan& plan, const TuningReadings& readings, double clip)
{
    if (clip <= 0.0) return {};
    std::vector<int> rows;
    for (int k = 0; k < plan.size(); ++k)
        if (isKnown(readings.values[k]) && std::abs(readings.values[k]) >= 0.99 * clip)
            rows.push_back(k);
    if (rows.empty()) return {};
    return fmt::format("the microphone clips: readings of {} rows reach its limit of {:g} ({}); "
                       "plan with a lower --duty, or move it away",
                       rows.size(),
                       clip,
                       rangesText(rows));
}

std::string placeRefusal(const TuningPlan& plan,
                         const TuningReadings& readings,
                         const Eigen::MatrixXd& expected,
                         const TuningResponses& responses,
                         int place)
{
    const std::vector<double> amplitudes = amplitudesOf(responses.y, place);
    if (amplitudes.empty()) return fmt::format("there are no readings of place {}", place);
    const double median = base::percentile(amplitudes, 0.5);
    if (!(median > kHeard * responses.noise[place]))
        return fmt::format("the microphone hears nothing at place {}: {:.3g} from the median "
                           "transducer, {:.3g} in silence; is it on, and does the array play?",
                           place,
                           median,
                           responses.noise[place]);
    if (plan.method == TuningMethod::LEVELS) return {}; // has its own test
    const auto [share, equalShare] = plateauShares(plan, readings, expected, place);
    if (share > kPlateauShare + 2.0 * equalShare)
        return fmt::format("the microphone seems to clip at place {}: {:.0f} % of the readings are "
                           "within 2 % of the loudest; plan with a lower --duty, or move it away",
                           place,
                           100.0 * share);
    return {};
}

} // namespace

TuningResponses responsesOf(const TuningPlan& plan,
                            const TuningReadings& readings,
                            const Eigen::MatrixXd& expected,
                            double clip)
{
    TuningResponses responses;
    const auto places = static_cast<int>(plan.places.cols());
    responses.y.setConstant(places, plan.transducers, {kNoResponse, kNoResponse});
    responses.noise.setZero(places);
    responses.refusal = clipRefusal(plan, readings, clip);
    for (int place = 0; place < places && responses.refusal.empty(); ++place)
    {
        if (plan.method == TuningMethod::HADAMARD)
            decodeHadamard(plan, readings, place, responses);
        else if (plan.method == TuningMethod::LEVELS)
            decodeLevels(plan, readings, place, responses);
        else
            decodeSingle(plan, readings, place, responses);
        if (responses.refusal.empty())
            responses.refusal = placeRefusal(plan, readings, expected, responses, place);
    }
    return responses;
}

} // namespace midair::haptics
