#include "haptics/boards/BoardFit.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/SmallMatrices.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/boards/BoardSolver.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kOutlier = 4.0;      // sigmas
constexpr double kInconsistent = 3.0; // noise over the given sigma
constexpr double kMostLeftOut = 0.1;
constexpr std::size_t kMostNamed = 8;

/// Does the work of fitBoards().
class Fit
{
public:
    Fit(const TransducerArray& array,
        const BoardMeasurements& measurements,
        const BoardFitOptions& options) :
        _array(array),
        _measurements(measurements),
        _options(options),
        _solver(array, measurements, options.soundSpeed_m_s),
        _used(measurements.all.size(), 1),
        _state(_solver.start())
    {
        _isAnchored = isAnchored();
    }

    BoardFitReport run()
    {
        _report.array = _array;
        findUnmeasured();
        if (!_report.problems.empty()) return _report;
        _solver.fit(_used, _options.sigma_m, -1, _state);
        leaveOutliers();
        if (!_isAnchored) align();
        _report.residuals_m = _solver.residuals_m(_state);
        _report.leftOut.resize(_used.size());
        for (std::size_t k = 0; k < _used.size(); ++k)
            _report.leftOut[k] = !_used[k];
        describe();
        judgeNoise();
        if (!_report.problems.empty()) return _report;
        if (!_isAnchored)
            _report.notes.push_back("distances are the same in a mirror: the arrangement like the "
                                    "array's is used, not its mirror image");
        for (const std::string& note : _solver.mirrorNotes(_used, _options.sigma_m, _state))
            _report.notes.push_back(note);
        _report.usable = true;
        moveAll();
        return _report;
    }

private:
    /// Returns true if known places define the frame. Throws if they do so only in part.
    bool isAnchored() const
    {
        std::set<int> known;
        for (const BoardMeasurement& one : _measurements.all)
            for (const MeasuredEnd* end : {&one.from, &one.to})
                if (end->place >= 0 &&
                    _measurements.places[static_cast<std::size_t>(end->place)].isKnown)
                    known.insert(end->place);
        if (known.empty()) return false;
        Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(known.size()));
        Eigen::Index at = 0;
        for (const int place : known)
            places.col(at++) = _measurements.places[static_cast<std::size_t>(place)].position;
        Eigen::Vector3d normal;
        if (places.cols() >= 3 && flatness(places, normal)[1] > kFlat_m) return true;
        throw base::InputError(fmt::format(
            "{} known {} measured to; use none (the array as a whole then stays in place) or at "
            "least three that are not in one line; \"place NAME about x y z\" is fitted, too",
            known.size(),
            known.size() == 1 ? "place is" : "places in one line are"));
    }

    void findUnmeasured()
    {
        for (int b = 0; b < _solver.boards(); ++b)
            if (_solver.measurementsOf(b, _used).empty())
                _report.problems.push_back(fmt::format("board {} has no measurement", b));
    }

    // At most one in ten, and never so many that none remain to check the others.
    void leaveOutliers()
    {
        const Eigen::VectorXd r = _solver.residuals_m(_state).cwiseAbs();
        const double median =
            base::percentile(std::vector<double>(r.data(), r.data() + r.size()), 0.5);
        const double limit_m = kOutlier * std::max(_options.sigma_m, 1.4826 * median);
        std::vector<char> kept = _used;
        int out = 0;
        for (Eigen::Index k = 0; k < r.size(); ++k)
            if (r[k] > limit_m)
            {
                kept[static_cast<std::size_t>(k)] = 0;
                ++out;
            }
        if (out == 0 || out > kMostLeftOut * static_cast<double>(r.size()) || freedom() - out <= 0)
            return;
        _used = kept;
        _solver.fit(_used, _options.sigma_m, -1, _state);
        for (std::size_t k = 0; k < _used.size(); ++k)
            if (!_used[k])
                _report.notes.push_back(
                    fmt::format("{} (line {}) is left out: the others contradict it by {:.1f} mm",
                                _measurements.all[k].name(),
                                _measurements.all[k].line,
                                -1e3 * _solver.residuals_m(_state)[static_cast<Eigen::Index>(k)]));
    }

    int unknowns() const { return _solver.parameters() - (_isAnchored ? 0 : 6); }
    int freedom() const
    {
        return static_cast<int>(std::count(_used.begin(), _used.end(), 1)) - unknowns();
    }

    // Moves everything so that the mean motion of the transducers is zero.
    void align()
    {
        const Eigen::Isometry3d back(
            base::nearestMotion(moved().positions, _array.positions, false));
        for (Eigen::Isometry3d& motion : _state.motion)
            motion = back * motion;
        for (Eigen::Vector3d& place : _state.places)
            place = back * place;
    }

    TransducerArray moved() const
    {
        TransducerArray array = _array;
        const std::vector<BoardRange> boards = boardsOf(array);
        for (std::size_t b = 0; b < boards.size(); ++b)
            moveBoard(_state.motion[b], boards[b], array);
        return array;
    }

    void moveAll()
    {
        _report.array = moved();
        for (std::size_t p = 0; p < _measurements.places.size(); ++p)
            if (!_measurements.places[p].isKnown)
                _report.places.push_back({_measurements.places[p].name, _state.places[p], false});
    }

    // Covariance of the parameters for errors of sigma; without known places, without rigid
    // motions.
    void describe()
    {
        Eigen::MatrixXd J = _solver.jacobian(_state) / _options.sigma_m;
        for (std::size_t k = 0; k < _used.size(); ++k)
            if (!_used[k]) J.row(static_cast<Eigen::Index>(k)).setZero();
        Eigen::MatrixXd H = J.transpose() * J;
        Eigen::MatrixXd G;
        if (!_isAnchored)
        {
            G = _solver.rigidMotions(_state);
            H += G * G.transpose() / std::pow(_options.sigma_m, 2);
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H);
        tellUndetermined(eigen.eigenvalues(), eigen.eigenvectors());
        const double least = 1e-12 * eigen.eigenvalues().maxCoeff();
        const Eigen::VectorXd variances = eigen.eigenvalues().cwiseMax(least).cwiseInverse();
        Eigen::MatrixXd C =
            eigen.eigenvectors() * variances.asDiagonal() * eigen.eigenvectors().transpose();
        if (!_isAnchored)
        {
            const Eigen::MatrixXd free =
                Eigen::MatrixXd::Identity(C.rows(), C.rows()) - G * G.transpose();
            C = (free * C * free).eval();
        }
        for (int b = 0; b < _solver.boards(); ++b)
            _report.boards.push_back(poseOf(b, C));
        _report.delay_s = _state.delay_m / _options.soundSpeed_m_s;
    }

    BoardPose poseOf(int board, const Eigen::MatrixXd& C) const
    {
        const auto worst = [&](int first)
        {
            const Eigen::Matrix3d part = C.block<3, 3>(first, first);
            return std::sqrt(std::max(0.0, base::symmetricAxes(part).values[2]));
        };
        BoardPose pose;
        pose.board = board;
        pose.measurements = static_cast<int>(_solver.measurementsOf(board, _used).size());
        pose.motion = _state.motion[static_cast<std::size_t>(board)];
        pose.moved_m =
            (_solver.middleOf(board, _state) - _solver.middleOf(board, _solver.start())).norm();
        pose.turned_deg = base::toDegrees(Eigen::AngleAxisd(pose.motion.linear()).angle());
        const int first = _solver.parameterOf(board);
        pose.uncertain_m = worst(first);
        pose.uncertain_deg = base::toDegrees(worst(first + 3) / BoardSolver::kArm_m);
        return pose;
    }

    // Names the board that moves most in each undetermined direction.
    void tellUndetermined(const Eigen::VectorXd& values, const Eigen::MatrixXd& vectors)
    {
        const double least = 1.0 / std::pow(_options.mostUncertain_m, 2);
        std::set<std::string> told;
        for (Eigen::Index k = 0; k < values.size() && values[k] < least; ++k)
        {
            const Eigen::VectorXd way = vectors.col(k);
            int worst = 0;
            bool isTurn = false;
            double most = 0.0;
            for (int b = 0; b < _solver.boards(); ++b)
                for (const bool turn : {false, true})
                {
                    const double size =
                        way.segment<3>(_solver.parameterOf(b) + (turn ? 3 : 0)).norm();
                    if (size <= most) continue;
                    most = size;
                    worst = b;
                    isTurn = turn;
                }
            if (most < 0.1) // a fitted place, or the delay
            {
                told.insert(
                    "a place given with \"about\", or the delay of times, is not determined");
                continue;
            }
            Eigen::Vector3d d =
                way.segment<3>(_solver.parameterOf(worst) + (isTurn ? 3 : 0)).normalized();
            Eigen::Index axis = 0;
            d.cwiseAbs().maxCoeff(&axis);
            if (d[axis] < 0.0) d = -d;
            told.insert(fmt::format(
                "board {} is not determined: it can {} ({:.1f}, {:.1f}, {:.1f}) without changing a "
                "measurement; measure it to a point at its side, in another direction",
                worst,
                isTurn ? "turn about" : "move along",
                d[0],
                d[1],
                d[2]));
        }
        _report.problems.insert(_report.problems.end(), told.begin(), told.end());
    }

    void judgeNoise()
    {
        const int left = freedom();
        double squares = 0.0;
        for (std::size_t k = 0; k < _used.size(); ++k)
            if (_used[k]) squares += std::pow(_report.residuals_m[static_cast<Eigen::Index>(k)], 2);
        _report.noise_m = left > 0 ? std::sqrt(squares / left) : 0.0;
        if (left <= 0)
        {
            if (_report.problems.empty())
                _report.notes.push_back(
                    "there are as many measurements as unknowns: a wrong one can't be found");
            return;
        }
        if (!(_report.noise_m > kInconsistent * _options.sigma_m)) return;
        std::vector<std::size_t> order(_used.size());
        std::iota(order.begin(), order.end(), 0U);
        std::sort(order.begin(),
                  order.end(),
                  [this](std::size_t a, std::size_t b)
                  {
                      return std::fabs(_report.residuals_m[static_cast<Eigen::Index>(a)]) >
                             std::fabs(_report.residuals_m[static_cast<Eigen::Index>(b)]);
                  });
        std::string worst;
        for (std::size_t k = 0; k < std::min(order.size(), kMostNamed); ++k)
            worst += fmt::format("{}{} {:+.1f} mm",
                                 k > 0 ? ", " : "",
                                 _measurements.all[order[k]].name(),
                                 1e3 * _report.residuals_m[static_cast<Eigen::Index>(order[k])]);
        _report.problems.push_back(fmt::format(
            "the measurements contradict each other: they fit to {:.1f} mm rms, where {:.1f} mm "
            "were expected (sigma); farthest off (fitted minus measured): {}",
            1e3 * _report.noise_m,
            1e3 * _options.sigma_m,
            worst));
    }

    const TransducerArray& _array;
    const BoardMeasurements& _measurements;
    const BoardFitOptions& _options;
    const BoardSolver _solver;
    bool _isAnchored = false;
    std::vector<char> _used;
    BoardState _state;
    BoardFitReport _report;
};

constexpr double kShortest_m = 0.01;
constexpr double kFree_m = 0.1;     // assumed displacement of boards before the first measurement
constexpr double kRedundancy = 1.5; // distances over unknowns

void check(const TransducerArray& array, const BoardPlanOptions& options)
{
    std::string error;
    if (!base::RangeCheck("plan: ")
             .within("longest_m", options.longest_m, kShortest_m, 10.0, " m")
             .within("sigma_m", options.sigma_m, 1e-6, 0.1, " m")
             .within("count", options.count, 0.0, 10000.0)
             .passed(&error))
        throw base::InputError(error);
    if (boardsOf(array).size() < 2)
        throw base::InputError("array \"" + array.name +
                               "\" has one board: there is no other to measure it to");
}

/// All corner to corner distances between boards within the tape's length.
std::vector<PlannedDistance> candidates(const TransducerArray& array, double longest_m)
{
    const BoardMarks marks(array);
    std::vector<PlannedDistance> found;
    for (int a = 0; a < marks.boards(); ++a)
        for (int b = a + 1; b < marks.boards(); ++b)
            for (const char from : {'a', 'b', 'c', 'd'})
                for (const char to : {'a', 'b', 'c', 'd'})
                {
                    PlannedDistance one;
                    one.fromTransducer = marks.corner(a, from);
                    one.toTransducer = marks.corner(b, to);
                    one.from = fmt::format("{}:{}", a, from);
                    one.to = fmt::format("{}:{}", b, to);
                    one.distance_m = (array.positions.col(one.fromTransducer) -
                                      array.positions.col(one.toTransducer))
                                         .norm();
                    if (one.distance_m >= kShortest_m && one.distance_m <= longest_m)
                        found.push_back(one);
                }
    return found;
}

BoardMeasurements measurementsOf(const std::vector<PlannedDistance>& distances)
{
    BoardMeasurements all;
    for (const PlannedDistance& planned : distances)
    {
        BoardMeasurement& one = all.all.emplace_back();
        one.from = {planned.from, planned.fromTransducer, -1};
        one.to = {planned.to, planned.toTransducer, -1};
        one.distance_m = planned.distance_m;
    }
    return all;
}

} // namespace

bool BoardFitOptions::isValid(std::string* error) const
{
    return base::RangeCheck("boards: ")
        .within("sigma_m", sigma_m, 1e-6, 0.1, " m")
        .within("soundSpeed_m_s", soundSpeed_m_s, 200.0, 500.0, " m/s")
        .above("mostUncertain_m", mostUncertain_m, 0.0, " m")
        .passed(error);
}

BoardFitReport fitBoards(const TransducerArray& array,
                         const BoardMeasurements& measurements,
                         const BoardFitOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    return Fit(array, measurements, options).run();
}

BoardPlan planBoards(const TransducerArray& array, const BoardPlanOptions& options)
{
    check(array, options);
    const std::vector<PlannedDistance> all = candidates(array, options.longest_m);
    const BoardMeasurements measurements = measurementsOf(all);
    const BoardSolver solver(array, measurements, 343.2);
    const BoardState state = solver.start();
    const Eigen::MatrixXd J = solver.jacobian(state) / options.sigma_m;
    // Covariance of the parameters, for boards that may initially be anywhere.
    const int P = solver.parameters();
    Eigen::MatrixXd C = Eigen::MatrixXd::Identity(P, P) * kFree_m * kFree_m;
    const auto wanted = static_cast<std::size_t>(
        options.count > 0 ? options.count : std::lround(kRedundancy * (P - 6)));
    std::vector<char> taken(all.size(), 0);
    BoardPlan plan;
    while (plan.distances.size() < std::min(wanted, all.size()))
    {
        Eigen::Index best = -1;
        double most = -1.0;
        const Eigen::MatrixXd JC = J * C;
        for (Eigen::Index k = 0; k < J.rows(); ++k)
        {
            if (taken[static_cast<std::size_t>(k)]) continue;
            const double gain = JC.row(k).dot(J.row(k));
            if (gain <= most) continue;
            most = gain;
            best = k;
        }
        // Sherman and Morrison: covariance after one more measurement.
        const Eigen::VectorXd column = JC.row(best).transpose();
        C -= column * column.transpose() / (1.0 + most);
        taken[static_cast<std::size_t>(best)] = 1;
        plan.distances.push_back(all[static_cast<std::size_t>(best)]);
    }
    std::sort(plan.distances.begin(),
              plan.distances.end(),
              [](const PlannedDistance& a, const PlannedDistance& b)
              {
                  return a.fromTransducer != b.fromTransducer ? a.fromTransducer < b.fromTransducer
                                                              : a.toTransducer < b.toTransducer;
              });
    BoardFitOptions fit;
    fit.sigma_m = options.sigma_m;
    const BoardFitReport report = fitBoards(array, measurementsOf(plan.distances), fit);
    plan.problems = report.problems;
    for (const BoardPose& board : report.boards)
        plan.uncertain_m = std::max(plan.uncertain_m, board.uncertain_m);
    if (!report.usable) plan.uncertain_m = std::numeric_limits<double>::infinity();
    return plan;
}

} // namespace midair::haptics
