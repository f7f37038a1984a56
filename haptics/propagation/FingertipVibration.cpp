#include "haptics/propagation/FingertipVibration.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace midair::haptics
{

double skinSensitivity(double frequency_Hz)
{
    constexpr double kBest_Hz = 220.0;
    const double ratio = frequency_Hz / kBest_Hz;
    return ratio < 1.0 ? ratio * ratio : 1.0 / (ratio * std::sqrt(ratio));
}

int feltWaves(int fields, double step_s)
{
    constexpr double kFastest_Hz = 1000.0;
    constexpr double kMostWaves = 256.0;
    if (fields < 2) return 0;
    // The margin keeps rounding from losing the last wave.
    return static_cast<int>(std::min(kMostWaves, kFastest_Hz * fields * step_s + 1e-9));
}

Eigen::SparseMatrix<double, Eigen::RowMajor> fingertipPads(const Eigen::Matrix3Xd& places)
{
    constexpr Eigen::Index kMostPads = 400;
    const Eigen::Index stride = (places.cols() + kMostPads - 1) / kMostPads;
    const Eigen::Index count = stride > 0 ? (places.cols() + stride - 1) / stride : 0;
    std::vector<Eigen::Triplet<double>> shares;
    for (Eigen::Index pad = 0; pad < count; ++pad)
    {
        const Eigen::Array<bool, 1, Eigen::Dynamic> isIn =
            (places.colwise() - places.col(pad * stride)).colwise().squaredNorm().array() <=
            kFingertipPad_m * kFingertipPad_m;
        const double share = 1.0 / static_cast<double>(isIn.count());
        for (Eigen::Index l = 0; l < places.cols(); ++l)
            if (isIn[l]) shares.emplace_back(static_cast<int>(pad), static_cast<int>(l), share);
    }
    Eigen::SparseMatrix<double, Eigen::RowMajor> pads(count, places.cols());
    pads.setFromTriplets(shares.begin(), shares.end());
    return pads;
}

double fingertipVibration(const Eigen::SparseMatrix<double, Eigen::RowMajor>& pads,
                          const RingingCourse& course,
                          double period_s)
{
    if (pads.rows() == 0) return 0.0;
    const double mean = (pads * course.mean).mean();
    double sum = 0.0;
    for (Eigen::Index h = 0; h < course.waves.cols(); ++h)
    {
        const double s = skinSensitivity(static_cast<double>(h + 1) / period_s);
        const Eigen::VectorXd re = pads * course.waves.col(h).real();
        const Eigen::VectorXd im = pads * course.waves.col(h).imag();
        sum += 0.5 * s * s * (re.squaredNorm() + im.squaredNorm());
    }
    return mean > 0.0 ? std::sqrt(sum / static_cast<double>(pads.rows())) / mean : 0.0;
}

} // namespace midair::haptics
