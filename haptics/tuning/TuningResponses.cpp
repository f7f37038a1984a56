#include "haptics/tuning/TuningResponses.h"

#include "haptics/base/Percentile.h"
#include "haptics/tuning/ResponseDecoding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kNoResponse = std::numeric_limits<double>::quiet_NaN();
// A microphone that clips gives many readings near its limit. Of transducers whose gains differ by
// 5 % a few per mille are within 2 % of the loudest; of equal ones as many as are equally far away.
constexpr double kPlateau = 0.98;
constexpr double kPlateauShare = 0.08;
// The median of |noise| is 0.83 of its rms: what is below this many times the rms is no signal.
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

// The share of readings at a place near the loudest of them, and that of equal transducers.
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
        return fmt::format("the microphone hears nothing at place {}: of the transducers {:.3g} in "
                           "the median, of silence {:.3g}; is it on, and does the array play?",
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
