#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

/// The largest |p| at \a points in Pa, summed up term by term in double precision from the model's
/// equation alone: p_l = sum_i P0 g_i D(theta) / R e^{-alpha R} e^{-j k R} e^{j phi_i} q_i.
inline double loudestInDouble(const Eigen::Matrix3Xd& points,
                              const midair::haptics::TransducerArray& array,
                              const midair::haptics::Medium& medium,
                              const std::vector<std::complex<float>>& q)
{
    const double k = 2.0 * M_PI * array.frequency_Hz / medium.soundSpeed();
    const double alpha = medium.attenuation(array.frequency_Hz);
    double loudest_Pa = 0.0;
    for (Eigen::Index l = 0; l < points.cols(); ++l)
    {
        std::complex<double> p = 0.0;
        for (int i = 0; i < array.size(); ++i)
        {
            const Eigen::Vector3d way = points.col(l) - array.positions.col(i);
            const double R = way.norm();
            const double D = midair::haptics::directivity(
                array.directivity, std::clamp(way.dot(array.normals.col(i)) / R, -1.0, 1.0));
            const double gain = array.gain.size() > 0 ? array.gain[i] : 1.0;
            const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
            p += std::polar(array.sourceAmplitude_Pa_m * gain * D / R * std::exp(-alpha * R),
                            offset - k * R) *
                 std::complex<double>(q[static_cast<std::size_t>(i)]);
        }
        loudest_Pa = std::max(loudest_Pa, std::abs(p));
    }
    return loudest_Pa;
}

inline double loudestInDouble(const Eigen::Matrix3Xd& points,
                              const midair::haptics::TransducerArray& array,
                              const midair::haptics::Medium& medium,
                              const Eigen::VectorXcf& q)
{
    return loudestInDouble(
        points, array, medium, std::vector<std::complex<float>>(q.data(), q.data() + q.size()));
}

/// What ears hear over loudestInDouble(): twice the pressure before a head (6 dB), and the P0 that
/// a transducer has by itself.
inline double earFactor(const midair::haptics::TransducerArray& array, double own_Pa_m = 0.0)
{
    return std::pow(10.0, 6.0 / 20.0) * std::max(1.0, own_Pa_m / array.sourceAmplitude_Pa_m);
}
