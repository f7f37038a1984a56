#pragma once

#include <Eigen/Core>

#include <cmath>
#include <complex>

namespace midair::haptics
{

/// |p|^2 over one turn of fields with steady pressures \a p (n x K), which ring with \a ringing_s:
/// n x (K times 400 moments), by small steps in time, sound at once.
inline Eigen::MatrixXd steppedSquares(const Eigen::MatrixXcd& p, double step_s, double ringing_s)
{
    constexpr Eigen::Index kMoments = 400; // in a step
    const double left = std::exp(-step_s / kMoments / ringing_s);
    Eigen::VectorXcd now = Eigen::VectorXcd::Zero(p.rows());
    Eigen::MatrixXd squares(p.rows(), p.cols() * kMoments);
    const int rounds = 2 + static_cast<int>(20.0 * ringing_s / step_s / double(p.cols()));
    for (int round = 0; round < rounds; ++round)
        for (Eigen::Index k = 0; k < p.cols(); ++k)
            for (Eigen::Index moment = 0; moment < kMoments; ++moment)
            {
                const Eigen::VectorXcd next = p.col(k) + (now - p.col(k)) * left;
                squares.col(k * kMoments + moment) = 0.5 * (now.cwiseAbs2() + next.cwiseAbs2());
                now = next;
            }
    return squares;
}

/// The square of the vibration under fingertips at all \a places (fewer than 400), over \a mean.
inline double steppedVibration2(const Eigen::Matrix3Xd& places,
                                const Eigen::MatrixXcd& p,
                                double step_s,
                                double ringing_s,
                                double mean)
{
    const Eigen::MatrixXd squares = steppedSquares(p, step_s, ringing_s);
    const double N = static_cast<double>(squares.cols()), period_s = step_s * double(p.cols());
    Eigen::MatrixXd pads = Eigen::MatrixXd::Zero(places.cols(), places.cols());
    for (Eigen::Index a = 0; a < places.cols(); ++a)
    {
        for (Eigen::Index l = 0; l < places.cols(); ++l)
            pads(a, l) = (places.col(a) - places.col(l)).norm() <= 0.007 ? 1.0 : 0.0;
        pads.row(a) /= pads.row(a).sum();
    }
    double sum = 0.0;
    for (int h = 1; h / period_s < 1000.5; ++h)
    {
        const double f_Hz = h / period_s;
        const double s = f_Hz < 220.0 ? std::pow(f_Hz / 220.0, 2.0) : std::pow(220.0 / f_Hz, 1.5);
        Eigen::VectorXcd turns(squares.cols());
        for (Eigen::Index t = 0; t < turns.size(); ++t)
            turns[t] = std::polar(2.0 / N, -2.0 * M_PI * h * (static_cast<double>(t) + 0.5) / N);
        const Eigen::VectorXcd wave = squares * turns;
        sum += 0.5 * s * s * (pads * wave).squaredNorm();
    }
    return sum / static_cast<double>(places.cols()) / (mean * mean);
}

} // namespace midair::haptics
