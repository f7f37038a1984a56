#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <cmath>
#include <complex>
#include <functional>

#include <gtest/gtest.h>

using namespace midair::haptics;

// The paper's first scene: a single focus, in the octagonal prism and in arrays for which the field
// is known in closed form.
namespace
{

const double kPi = std::acos(-1.0);

Eigen::VectorXcf
focusedAt(const Eigen::Vector3d& focus, const TransducerArray& array, const Medium& medium)
{
    const Eigen::MatrixXcd G = referencePropagationMatrix(focus, array, medium);
    return G.row(0).conjugate().cwiseQuotient(G.row(0).cwiseAbs()).cast<std::complex<float>>();
}

// The model of propagation once more, written apart from the library: plain sums, the harmonics by
// the standard library.
std::complex<double> fieldByHand(const Eigen::Vector3d& r,
                                 const TransducerArray& array,
                                 const Medium& medium,
                                 const Eigen::VectorXcf& q)
{
    const double c[] = {1.11, 1.06, 0.24, -0.12};
    const double k = 2.0 * kPi * array.frequency_Hz / medium.soundSpeed();
    std::complex<double> p = 0.0;
    for (int i = 0; i < array.size(); ++i)
    {
        const double x = r.x() - array.positions(0, i);
        const double y = r.y() - array.positions(1, i);
        const double z = r.z() - array.positions(2, i);
        const double R = std::sqrt(x * x + y * y + z * z);
        const double cosine =
            (x * array.normals(0, i) + y * array.normals(1, i) + z * array.normals(2, i)) / R;
        double D = 0.0;
        double onAxis = 0.0;
        for (unsigned n = 0; n < 4; ++n)
        {
            D += c[n] * std::sqrt(2.0 * n + 1.0) * std::legendre(n, cosine);
            onAxis += c[n] * std::sqrt(2.0 * n + 1.0);
        }
        const std::complex<double> j(0.0, 1.0);
        p += array.sourceAmplitude_Pa_m * std::max(0.0, D / onAxis) / R *
             std::exp(-(medium.attenuation(array.frequency_Hz) + j * k) * R) *
             std::complex<double>(q[i]);
    }
    return p;
}

// Where |f|, falling from f(0), is first half of it.
double halfWidth(const std::function<double(double)>& f)
{
    const double half = 0.5 * f(0.0);
    double low = 0.0;
    double high = 0.0;
    while (f(high) > half)
        high += 0.2e-3;
    low = high - 0.2e-3;
    for (int step = 0; step < 40; ++step)
    {
        const double middle = 0.5 * (low + high);
        (f(middle) > half ? low : high) = middle;
    }
    return low;
}

TransducerArray pointSources(const Eigen::Matrix3Xd& positions)
{
    TransducerArray array;
    array.directivity = Directivity::POINT;
    array.positions = positions;
    array.normals = -positions.colwise().normalized();
    array.board.assign(static_cast<std::size_t>(positions.cols()), 0);
    return array;
}

double pressureFrom(const TransducerArray& array,
                    const Medium& medium,
                    const Eigen::VectorXcf& q,
                    const Eigen::Vector3d& r)
{
    return std::abs(pressureAt(r, array, medium, q)[0]);
}

} // namespace

TEST(PaperFocus, ArrivalsAreInPhaseAndAddUp)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    const Eigen::VectorXcf q = focusedAt(Eigen::Vector3d::Zero(), array, medium);
    const Eigen::MatrixXcd G = referencePropagationMatrix(Eigen::Vector3d::Zero(), array, medium);
    for (int i = 0; i < array.size(); ++i) // 1e-6: the rounding of q to float
    {
        EXPECT_NEAR(std::arg(G(0, i) * std::complex<double>(q[i])), 0.0, 1e-6);
        EXPECT_NEAR(std::abs(q[i]), 1.0f, 1e-6f);
    }
    // The peak, all arrivals in phase: P0 sum_i D_i e^{-beta R_i}/R_i, by hand; 1e-5 is the float
    // path's.
    const double byHand = std::abs(fieldByHand(Eigen::Vector3d::Zero(), array, medium, q));
    EXPECT_NEAR(byHand / G.cwiseAbs().sum(), 1.0, 1e-6);
    EXPECT_NEAR(pressureFrom(array, medium, q, Eigen::Vector3d::Zero()) / byHand, 1.0, 1e-5);
    // In the linear model full drive makes 5.53 kPa rms / sin(pi 32/510); air would not carry that
    // linearly.
    EXPECT_NEAR(byHand / std::sqrt(2.0), 5530.0 / std::sin(kPi * 32.0 / 510.0), 100.0);
}

TEST(PaperFocus, FieldRoundTheFocusAgreesWithTheModelWrittenAnew)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium{14.5, 0.5, 101325.0}; // the paper's wavelength of 8.5 mm
    const Eigen::Vector3d focus(0.01, 0.02, -0.015);
    const Eigen::VectorXcf q = focusedAt(focus, array, medium);
    FieldGrid grid;
    grid.corner = focus - Eigen::Vector3d(0.02, 0.015, 0.01);
    grid.u = Eigen::Vector3d(0.04, 0, 0.02);
    grid.v = Eigen::Vector3d(0, 0.03, 0);
    grid.columns = 9;
    grid.rows = 7;
    const Eigen::Matrix3Xd points = grid.points();
    const Eigen::VectorXcf p = pressureAt(points, array, medium, q);
    const double peak = std::abs(fieldByHand(focus, array, medium, q));
    for (Eigen::Index l = 0; l < points.cols(); ++l)
    {
        const std::complex<double> byHand = fieldByHand(points.col(l), array, medium, q);
        EXPECT_LE(std::abs(std::complex<double>(p[l]) - byHand), 1e-5 * peak) << "point " << l;
        EXPECT_LE(std::abs(p[l]), peak * (1 + 1e-5)); // nowhere more than at the focus
    }
}

TEST(PaperFocus, SphereOfSourcesFocusesToASinc)
{
    // Plane waves from all round: |p|/p0 = |sin(k r)/(k r)|, half at k r = 1.895. Radius 3 m: the
    // waves' curvature changes the phase by k r^2/(2 radius) = 0.04 at most, of which the even part
    // is left: under 1 % of the peak.
    constexpr int kSources = 3000;
    Eigen::Matrix3Xd positions(3, kSources);
    for (int i = 0; i < kSources; ++i)
    {
        const double z = 1.0 - (2.0 * i + 1.0) / kSources;
        const double phi = 2.399963229728653 * i; // the golden angle
        positions.col(i) << std::sqrt(1.0 - z * z) * std::cos(phi),
            std::sqrt(1.0 - z * z) * std::sin(phi), z;
    }
    const TransducerArray array = pointSources(3.0 * positions);
    const Medium medium;
    const Eigen::VectorXcf q = focusedAt(Eigen::Vector3d::Zero(), array, medium);
    const double k = 2.0 * kPi / medium.wavelength(array.frequency_Hz);
    const double peak = pressureFrom(array, medium, q, Eigen::Vector3d::Zero());
    for (const Eigen::Vector3d& direction :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0.6, 0, 0.8)})
    {
        for (double r = 0.5e-3; r < 18e-3; r += 0.5e-3)
            EXPECT_NEAR(pressureFrom(array, medium, q, r * direction) / peak,
                        std::abs(std::sin(k * r) / (k * r)),
                        0.01);
        const double width =
            halfWidth([&](double r) { return pressureFrom(array, medium, q, r * direction); });
        EXPECT_NEAR(k * width, 1.89549, 0.01);
    }
}

TEST(PaperFocus, RingOfSourcesFocusesToABesselFunction)
{
    // In the ring's plane |p|/p0 = |J0(k r)|, half at k r = 1.521; on the ring's axis the waves
    // stay in phase: no focus.
    constexpr int kSources = 720;
    Eigen::Matrix3Xd positions(3, kSources);
    for (int i = 0; i < kSources; ++i)
    {
        const double phi = 2.0 * kPi * i / kSources;
        positions.col(i) << 3.0 * std::sin(phi), 0.0, 3.0 * std::cos(phi);
    }
    const TransducerArray array = pointSources(positions);
    const Medium medium;
    const Eigen::VectorXcf q = focusedAt(Eigen::Vector3d::Zero(), array, medium);
    const double k = 2.0 * kPi / medium.wavelength(array.frequency_Hz);
    const double peak = pressureFrom(array, medium, q, Eigen::Vector3d::Zero());
    const Eigen::Vector3d direction(0.28, 0.0, 0.96);
    for (double r = 0.5e-3; r < 18e-3; r += 0.5e-3) // 1 %: curvature, as above
        EXPECT_NEAR(pressureFrom(array, medium, q, r * direction) / peak,
                    std::abs(std::cyl_bessel_j(0, k * r)),
                    0.01);
    const double width =
        halfWidth([&](double r) { return pressureFrom(array, medium, q, r * direction); });
    EXPECT_NEAR(k * width, 1.52112, 0.01);
    EXPECT_NEAR(pressureFrom(array, medium, q, {0, 9e-3, 0}) / peak, 1.0, 1e-3);
}

TEST(PaperFocus, WidthInThePrismIsThatOfItsRings)
{
    // Round the y axis the prism is a stack of rings; one seen from the centre at an elevation e_i
    // adds w_i J0(k rho cos e_i) across the axis and w_i cos(k y sin e_i) along it, w_i = D_i
    // e^{-beta R_i}/R_i. The octagon's flat sides and the waves' curvature leave up to 2 % of the
    // peak within a wavelength.
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    const Eigen::VectorXcf q = focusedAt(Eigen::Vector3d::Zero(), array, medium);
    const Eigen::MatrixXcd G = referencePropagationMatrix(Eigen::Vector3d::Zero(), array, medium);
    const double k = 2.0 * kPi / medium.wavelength(array.frequency_Hz);
    const double peak = G.cwiseAbs().sum();
    const auto closed = [&](double x, bool across)
    {
        double p = 0.0;
        for (int i = 0; i < array.size(); ++i)
        {
            const double sine = array.positions(1, i) / array.positions.col(i).norm();
            p += std::abs(G(0, i)) * (across
                                          ? std::cyl_bessel_j(0, k * x * std::sqrt(1 - sine * sine))
                                          : std::cos(k * x * sine));
        }
        return std::abs(p);
    };
    const auto played = [&](double x, const Eigen::Vector3d& direction)
    { return pressureFrom(array, medium, q, x * direction); };
    for (double x = 0.0; x < 8.6e-3; x += 0.43e-3)
    {
        EXPECT_NEAR(played(x, {1, 0, 0}) / peak, closed(x, true) / peak, 0.02) << x;
        EXPECT_NEAR(played(x, {0, 0, 1}) / peak, closed(x, true) / peak, 0.02) << x;
        EXPECT_NEAR(played(x, {0, 1, 0}) / peak, closed(x, false) / peak, 0.02) << x;
    }
    const double across_m = halfWidth([&](double x) { return closed(x, true); });
    const double along_m = halfWidth([&](double x) { return closed(x, false); });
    const double across = halfWidth([&](double x) { return played(x, {1, 0, 0}); });
    const double along = halfWidth([&](double x) { return played(x, {0, 1, 0}); });
    EXPECT_NEAR(across / across_m, 1.0, 0.02);
    EXPECT_NEAR(along / along_m, 1.0, 0.02);
    RecordProperty("full_width_across_mm", std::to_string(2e3 * across));
    RecordProperty("full_width_along_mm", std::to_string(2e3 * along));
    // About half a wavelength across, longer along the axis, where the prism is open.
    EXPECT_GT(along, across);
    EXPECT_NEAR(2.0 * across / medium.wavelength(40e3), 0.5, 0.05);
}
