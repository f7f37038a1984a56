#include "haptics/tolerance/ToleranceStudy.h"

#include "haptics/array/BoardGrid.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

namespace midair::haptics
{

namespace
{

constexpr int kMostDraws = 10000;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Name of a deviation, its values in the options, and their range.
struct DeviationRow
{
    const char* name;
    const char* unit;
    const char* option;
    std::vector<double> ToleranceOptions::*values;
    double low, high;
};

/// Indexed by Deviation.
constexpr DeviationRow kDeviations[] = {
    {"position", "m", "position_m", &ToleranceOptions::position_m, 0.0, 0.1},
    {"tilt", "deg", "tilt_deg", &ToleranceOptions::tilt_deg, 0.0, 45.0},
    {"phase", "deg", "phase_deg", &ToleranceOptions::phase_deg, 0.0, 180.0},
    {"temperature", "K", "temperature_K", &ToleranceOptions::temperature_K, -50.0, 50.0},
    {"dead", "share", "dead", &ToleranceOptions::dead, 0.0, 1.0}};

/// A real array and its air.
struct Reality
{
    TransducerArray array;
    Medium medium;
};

using Random = std::mt19937_64;

Eigen::Vector3d normalVector(double rms, Random& random)
{
    std::normal_distribution<double> normal(0.0, rms);
    const double x = normal(random), y = normal(random);
    return {x, y, normal(random)};
}

void displace(double rms_m, Random& random, TransducerArray& array)
{
    for (const BoardRange& board : boardsOf(array))
        moveBoard(Eigen::Isometry3d(Eigen::Translation3d(normalVector(1.0, random) * rms_m)),
                  board,
                  array);
}

void tilt(double rms_deg, Random& random, TransducerArray& array)
{
    for (const BoardRange& board : boardsOf(array))
    {
        const Eigen::Vector3d turn = normalVector(1.0, random) * base::toRadians(rms_deg);
        const Eigen::Vector3d middle = middleOf(array, board);
        const Eigen::AngleAxisd rotation(turn.norm(), turn.stableNormalized());
        moveBoard(
            Eigen::Translation3d(middle) * rotation * Eigen::Translation3d(-middle), board, array);
    }
}

void spreadPhases(double rms_deg, Random& random, TransducerArray& array)
{
    std::normal_distribution<double> normal;
    if (array.phaseOffset_rad.size() == 0) array.phaseOffset_rad.setZero(array.size());
    for (double& offset_rad : array.phaseOffset_rad)
        offset_rad += base::toRadians(rms_deg) * normal(random);
}

// A prefix of one random order, so that transducers dead at a lower share are also dead at a higher
// one.
void kill(double share, Random& random, TransducerArray& array)
{
    std::vector<int> order(static_cast<std::size_t>(array.size()));
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    order.resize(static_cast<std::size_t>(std::lround(share * array.size())));
    array.setDead(order);
}

void deviate(Deviation deviation, double value, Random& random, Reality& reality)
{
    switch (deviation)
    {
    case Deviation::POSITION:
        return displace(value, random, reality.array);
    case Deviation::TILT:
        return tilt(value, random, reality.array);
    case Deviation::PHASE:
        return spreadPhases(value, random, reality.array);
    case Deviation::TEMPERATURE:
        reality.medium.temperature_C += value;
        return;
    case Deviation::DEAD:
        return kill(value, random, reality.array);
    }
}

/// Output of one array.
struct Played
{
    double rms, loudness, focus;
};

/// Plays the sequence, and a focus in the middle of its points.
class Player
{
public:
    Player(const FieldSequence& sequence, const Reality& nominal, int threads) :
        _sequence(sequence),
        _points(sequence.points()),
        _threads(threads)
    {
        _middle = _points.positions.rowwise().mean();
        const Eigen::MatrixXcd G =
            referencePropagationMatrix(_middle, nominal.array, nominal.medium);
        _focus.setZero(nominal.array.size());
        for (Eigen::Index i = 0; i < G.cols(); ++i)
        {
            const double magnitude = std::abs(G(0, i));
            _full_Pa += magnitude;
            if (magnitude > 0.0) _focus[i] = std::complex<float>(std::conj(G(0, i)) / magnitude);
        }
        _nominal = sequence.report;
        rateLevel(
            _points, achievedPressure(sequence, nominal.array, nominal.medium, threads), _nominal);
    }

    Played play(const Reality& reality) const
    {
        SolveReport report = _nominal;
        rateLevel(
            _points, achievedPressure(_sequence, reality.array, reality.medium, _threads), report);
        const float focus_Pa =
            std::abs(pressureAt(_middle, reality.array, reality.medium, _focus, _threads)[0]);
        return {report.rms, report.loudness, static_cast<double>(focus_Pa) / _full_Pa};
    }

    int points() const { return _points.size(); }

private:
    const FieldSequence& _sequence;
    const ControlPoints _points;
    const int _threads;
    Eigen::Matrix3Xd _middle;
    Eigen::VectorXcf _focus;
    double _full_Pa = 0.0;
    SolveReport _nominal;
};

ToleranceRow rowOf(Deviation deviation, double value, const std::vector<Played>& all)
{
    const auto of = [&](double Played::*figure, double fraction)
    {
        std::vector<double> values;
        values.reserve(all.size());
        for (const Played& one : all)
            values.push_back(one.*figure);
        return base::percentile(std::move(values), fraction);
    };
    ToleranceRow row;
    row.deviation = deviation;
    row.value = value;
    row.draws = static_cast<int>(all.size());
    row.rms = of(&Played::rms, 0.5);
    row.rms90 = of(&Played::rms, 0.9);
    row.loudness = of(&Played::loudness, 0.5);
    row.loudness10 = of(&Played::loudness, 0.1);
    row.focus = of(&Played::focus, 0.5);
    row.focus10 = of(&Played::focus, 0.1);
    row.expectedRms = row.expectedFocus = kNone;
    return row;
}

// Errors for independent deviations. Phase errors s change p_l = sum_i G_li q_i by sum_i G_li q_i j
// delta_i; |p_l| changes by the part along p_l, half of the square if the waves at a point have all
// phases: s sqrt(n/2m)/E of p_l. It adds to the existing errors.
void expect(const ToleranceRow& nominal, int points, int transducers, ToleranceRow& row)
{
    if (row.deviation == Deviation::DEAD) row.expectedFocus = 1.0 - row.value;
    if (row.deviation != Deviation::PHASE) return;
    const double s = base::toRadians(row.value);
    row.expectedFocus = std::exp(-0.5 * s * s);
    const double added = s * std::sqrt(0.5 * points / transducers) / nominal.loudness;
    row.expectedRms = std::hypot(nominal.rms, added);
}

double processor_s()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

} // namespace

bool ToleranceOptions::isValid(std::string* error) const
{
    base::RangeCheck check("tolerance: ");
    for (const DeviationRow& row : kDeviations)
        for (const double value : this->*row.values)
            check.within(row.option, value, row.low, row.high);
    return check.within("draws", draws, 1.0, kMostDraws)
        .within("threads", threads, 1.0, base::kMostThreads)
        .passed(error);
}

ToleranceStudy toleranceOf(const FieldSequence& sequence,
                           const TransducerArray& array,
                           const Medium& medium,
                           const ToleranceOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    if (sequence.points().size() == 0 || !(sequence.report.level_Pa > 0.0))
        throw base::InputError("tolerance: the field is silent or has no points");
    const double start_s = processor_s();
    const Reality nominal{array, medium};
    const Player player(sequence, nominal, options.threads);
    ToleranceStudy study;
    study.nominal = rowOf(Deviation::POSITION, 0.0, {player.play(nominal)});
    study.draws = options.draws;
    study.arrays = 1;
    for (const Deviation deviation : {Deviation::POSITION,
                                      Deviation::TILT,
                                      Deviation::PHASE,
                                      Deviation::TEMPERATURE,
                                      Deviation::DEAD})
        for (const double value : options.*kDeviations[static_cast<std::size_t>(deviation)].values)
        {
            std::vector<Played> all;
            const int draws = deviation == Deviation::TEMPERATURE ? 1 : options.draws;
            for (int draw = 0; draw < draws; ++draw)
            {
                std::seed_seq seeds{options.seed & 0xFFFFFFFFU,
                                    options.seed >> 32U,
                                    static_cast<std::uint64_t>(deviation),
                                    static_cast<std::uint64_t>(draw)};
                Random random(seeds);
                Reality reality = nominal;
                deviate(deviation, value, random, reality);
                if (!reality.medium.isValid(&error)) throw base::InputError("tolerance: " + error);
                all.push_back(player.play(reality));
            }
            study.arrays += draws;
            study.rows.push_back(rowOf(deviation, value, all));
            expect(study.nominal, player.points(), array.size(), study.rows.back());
        }
    study.cpu_s = processor_s() - start_s;
    return study;
}

const char* deviationName(Deviation deviation)
{
    return kDeviations[static_cast<std::size_t>(deviation)].name;
}

const char* deviationUnit(Deviation deviation)
{
    return kDeviations[static_cast<std::size_t>(deviation)].unit;
}

} // namespace midair::haptics
