#pragma once

#include "haptics/boards/BoardMeasurements.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Where boards and fitted places are, and the delay of all times, as a length.
struct BoardState
{
    std::vector<Eigen::Isometry3d> motion; ///< of each board, from where the array has it
    std::vector<Eigen::Vector3d> places;   ///< of each place
    double delay_m = 0.0;                  ///< speed of sound times the delay
};

/// Least squares of distances: unknown are a rigid motion of each board, the places that are known
/// about, and the delay of times. Parameters are metres: turns are in arcs at kArm_m.
///     r_k = |x_from - x_to| + [time] delay - measured_k
/// The fit's own loop damps all parameters alike, in metres, so that boards which were put up far
/// off are found near where they are meant to be. Eigen's (unsupported) Levenberg-Marquardt, with
/// Huber's cost as squares, ends in a mirror image or elsewhere for some of them (BoardFit.FarOff).
class BoardSolver
{
public:
    static constexpr double kArm_m = 0.1; ///< about half a board

    /// References are kept. \a soundSpeed_m_s turns times into lengths.
    BoardSolver(const TransducerArray& array,
                const BoardMeasurements& measurements,
                double soundSpeed_m_s);

    BoardState start() const; ///< as the array has them
    int parameters() const { return _parameters; }
    int parameterOf(int board) const { return 6 * board; } ///< of six: shift, then turn

    /// Fits by Levenberg-Marquardt with Huber's weights beyond \a sigma_m, for the measurements in
    /// \a used (0, 1), from \a state. \a freeBoard: only this one moves; -1: all.
    void fit(const std::vector<char>& used, double sigma_m, int freeBoard, BoardState& state) const;

    /// Returns a sentence for each board that could as well be on the other side of a plane, since
    /// what it is measured to is in one: it is reflected and fitted from there, and found to fit as
    /// well.
    std::vector<std::string>
    mirrorNotes(const std::vector<char>& used, double sigma_m, const BoardState& state) const;

    /// Returns the measurements in \a used (0, 1) that \a board is in.
    std::vector<BoardMeasurement> measurementsOf(int board, const std::vector<char>& used) const;
    Eigen::VectorXd residuals_m(const BoardState& state) const;
    Eigen::MatrixXd jacobian(const BoardState& state) const;
    /// Rigid motions of everything, as orthonormal columns of parameters (P x 6).
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
    int _parameterOfDelay = -1;         // -1: there are no times
    int _parameters = 0;
};

/// Points within this of a plane or a line don't tell its sides apart, m.
constexpr double kFlat_m = 3e-3;

/// Returns how far, rms, \a places are from their best plane (first) and from their best line, m,
/// and the plane's normal.
Eigen::Vector2d flatness(const Eigen::Matrix3Xd& places, Eigen::Vector3d& normal);

} // namespace midair::haptics
