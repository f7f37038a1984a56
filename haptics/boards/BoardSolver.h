#pragma once

#include "haptics/boards/BoardMeasurements.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Motions of boards, positions of fitted places, and the delay of all times as a length.
struct BoardState
{
    std::vector<Eigen::Isometry3d> motion; ///< of each board, from its pose in the array
    std::vector<Eigen::Vector3d> places;   ///< of each place
    double delay_m = 0.0;                  ///< speed of sound times the delay
};

/// Least-squares fit of distances. Unknowns: a rigid motion per board, approximately known places,
/// and the delay of times. Parameters are metres: rotations are arcs at kArm_m.
///     r_k = |x_from - x_to| + [time] delay - measured_k
/// This loop damps all parameters alike, in metres, so that boards mounted far off are found near
/// their intended pose. Eigen's (unsupported) Levenberg-Marquardt, with Huber's cost as squares,
/// ends in mirror images or elsewhere for some of them (BoardFit.FarOff).
class BoardSolver
{
public:
    static constexpr double kArm_m = 0.1; ///< about half a board

    /// Keeps the references. \a soundSpeed_m_s converts times to lengths.
    BoardSolver(const TransducerArray& array,
                const BoardMeasurements& measurements,
                double soundSpeed_m_s);

    BoardState start() const; ///< the array's poses
    int parameters() const { return _parameters; }
    int parameterOf(int board) const
    {
        return 6 * board;
    } ///< first of six: translation, then
      ///< rotation

    /// Fits by Levenberg-Marquardt with Huber weights beyond \a sigma_m to the measurements in \a
    /// used (0, 1), starting from \a state. \a freeBoard: only this board moves; -1: all.
    void fit(const std::vector<char>& used, double sigma_m, int freeBoard, BoardState& state) const;

    /// Returns a sentence for each board with a mirrored solution, because its measured places lie
    /// in a plane: the board is reflected and fitted again, and fits as well.
    std::vector<std::string>
    mirrorNotes(const std::vector<char>& used, double sigma_m, const BoardState& state) const;

    /// Returns the measurements in \a used (0, 1) of \a board.
    std::vector<BoardMeasurement> measurementsOf(int board, const std::vector<char>& used) const;
    Eigen::VectorXd residuals_m(const BoardState& state) const;
    Eigen::MatrixXd jacobian(const BoardState& state) const;
    /// Rigid motions of the whole, as orthonormal columns of parameters (P x 6).
    Eigen::MatrixXd rigidMotions(const BoardState& state) const;
    Eigen::Vector3d at(const MeasuredEnd& end, const BoardState& state) const;
    Eigen::Vector3d middleOf(int board, const BoardState& state) const;
    int boards() const { return static_cast<int>(_boards.size()); }
    int boardOf(const MeasuredEnd& end) const; ///< -1: a place

private:
    void step(const Eigen::VectorXd& by, BoardState& state) const;
    bool reflect(int board, const std::vector<char>& used, BoardState& state) const;
    Eigen::ArrayXd
    sigmasOf(const std::vector<char>& used, double sigma_m, const BoardState& state) const;
    void addEnd(const MeasuredEnd& end,
                const Eigen::Vector3d& along,
                const BoardState& state,
                Eigen::Ref<Eigen::RowVectorXd> row) const;

    const TransducerArray& _array;
    const BoardMeasurements& _measurements;
    const double _soundSpeed_m_s;
    const std::vector<BoardRange> _boards;
    std::vector<int> _boardOf;
    std::vector<int> _parameterOfPlace; // -1: it is known
    int _parameterOfDelay = -1;         // -1: no times
    int _parameters = 0;
};

/// Points within this of a plane or line can't distinguish its sides, m.
constexpr double kFlat_m = 3e-3;

/// Returns the rms distances, m, of \a places from their best plane (first) and best line, and the
/// plane's normal.
Eigen::Vector2d flatness(const Eigen::Matrix3Xd& places, Eigen::Vector3d& normal);

} // namespace midair::haptics
