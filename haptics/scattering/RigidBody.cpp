#include "haptics/scattering/RigidBody.h"

#include "haptics/base/Units.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/scattering/Kernels.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <utility>

namespace midair::haptics
{

namespace
{

using scattering::Complex;
using Corners = std::array<Eigen::Vector3d, 3>;

constexpr int kMostIterations = 500;

/// A rule on a triangle (Dunavant 1985, 10.1002/nme.1620210612): barycentric coordinates and
/// weights that sum up to 1.
struct TrianglePoint
{
    double a, b, c, weight;
};
constexpr std::array<TrianglePoint, 3> kRule3 = {{{2.0 / 3, 1.0 / 6, 1.0 / 6, 1.0 / 3},
                                                  {1.0 / 6, 2.0 / 3, 1.0 / 6, 1.0 / 3},
                                                  {1.0 / 6, 1.0 / 6, 2.0 / 3, 1.0 / 3}}};
constexpr double kOuter = 0.797426985353087, kOuterSide = 0.101286507323456,
                 kOuterWeight = 0.125939180544827;
constexpr double kInner = 0.059715871789770, kInnerSide = 0.470142064105115,
                 kInnerWeight = 0.132394152788506;
constexpr std::array<TrianglePoint, 7> kRule7 = {{{1.0 / 3, 1.0 / 3, 1.0 / 3, 0.225},
                                                  {kOuter, kOuterSide, kOuterSide, kOuterWeight},
                                                  {kOuterSide, kOuter, kOuterSide, kOuterWeight},
                                                  {kOuterSide, kOuterSide, kOuter, kOuterWeight},
                                                  {kInner, kInnerSide, kInnerSide, kInnerWeight},
                                                  {kInnerSide, kInner, kInnerSide, kInnerWeight},
                                                  {kInnerSide, kInnerSide, kInner, kInnerWeight}}};

template<typename Rule, typename Function>
Complex overTriangle(const Rule& rule, const Corners& t, double area, Function&& f)
{
    Complex sum = 0.0;
    for (const TrianglePoint& at : rule)
        sum += at.weight * f(Eigen::Vector3d(at.a * t[0] + at.b * t[1] + at.c * t[2]));
    return area * sum;
}

/// The integral of \a f, which isn't smooth at \a x, over a triangle at some distance from it.
template<typename Function>
Complex
integral(const Eigen::Vector3d& x, const Corners& t, double area, int most, const Function& f)
{
    const double size = std::sqrt(area);
    const double ratio = ((t[0] + t[1] + t[2]) / 3.0 - x).norm() / size;
    if (ratio > 4.0) return overTriangle(kRule3, t, area, f);
    if (ratio > 2.0 || most == 0) return overTriangle(kRule7, t, area, f);
    const Eigen::Vector3d ab = 0.5 * (t[0] + t[1]), bc = 0.5 * (t[1] + t[2]),
                          ca = 0.5 * (t[2] + t[0]);
    Complex sum = 0.0;
    for (const Corners& part :
         {Corners{t[0], ab, ca}, Corners{ab, t[1], bc}, Corners{ca, bc, t[2]}, Corners{ab, bc, ca}})
        sum += integral(x, part, 0.25 * area, most - 1, f);
    return sum;
}

constexpr int kDivisions = 5;

/// -1/(4 pi) contour e^{-jkR}/R dtheta - jk/2: the second derivative of a triangle's double layer
/// at its own centre.
Complex ownSecond(double k, const Eigen::Vector3d& centre, const Corners& t)
{
    Complex contour = 0.0;
    for (int edge = 0; edge < 3; ++edge)
    {
        const Eigen::Vector3d a = t[static_cast<std::size_t>(edge)] - centre,
                              b = t[static_cast<std::size_t>((edge + 1) % 3)] - centre;
        // R = distance / cos(theta) from the foot of the perpendicular.
        const Eigen::Vector3d along = (b - a).normalized();
        const double distance = (a - a.dot(along) * along).norm();
        const double from = std::atan2(a.dot(along), distance),
                     to = std::atan2(b.dot(along), distance);
        constexpr int kSteps = 16; // midpoints; the integrand is smooth
        for (int step = 0; step < kSteps; ++step)
        {
            const double theta = from + (to - from) * (step + 0.5) / kSteps;
            const double R = distance / std::cos(theta);
            contour += std::polar((to - from) / kSteps / R, -k * R);
        }
    }
    return -scattering::kInverse4Pi * contour - Complex(0.0, 0.5 * k);
}

} // namespace

ClosedBody
RigidBody::divided(const TriangleMesh& mesh, double wavelength_m, double elementsPerWavelength)
{
    return ClosedBody::from(mesh, wavelength_m / elementsPerWavelength, kMostElements);
}

RigidBody::RigidBody(ClosedBody body,
                     double wavelength_m,
                     int threads,
                     const base::StopToken& stop) :
    _body(std::move(body)),
    _k(base::kTwoPi / wavelength_m),
    _threads(threads)
{
    makeMatrix(threads, stop);
}

double RigidBody::bytesFor(Eigen::Index elements)
{
    const auto n = static_cast<double>(elements);
    return n * n * sizeof(std::complex<float>) + 100.0 * n * sizeof(Complex);
}

// p/2 - int p dG/dn_y - alpha int p d2G/dn_x dn_y = p_inc + alpha dp_inc/dn, alpha = -j/k.
void RigidBody::makeMatrix(int threads, const base::StopToken& stop)
{
    const Eigen::Index n = _body.size();
    _matrix.resize(n, n);
    const Complex alpha(0.0, -1.0 / _k);
    base::ThreadPool pool(threads);
    pool.run(
        [&](int thread)
        {
            for (Eigen::Index i = thread; i < n && !stop.requested(); i += threads)
            {
                const Eigen::Vector3d x = _body.centres.col(i), nx = _body.normals.col(i);
                for (Eigen::Index j = 0; j < n; ++j)
                {
                    const Corners t{_body.corners.col(3 * j),
                                    _body.corners.col(3 * j + 1),
                                    _body.corners.col(3 * j + 2)};
                    if (i == j)
                    {
                        _matrix(j, i) = std::complex<float>(0.5 - alpha * ownSecond(_k, x, t));
                        continue;
                    }
                    const Eigen::Vector3d ny = _body.normals.col(j);
                    const double cosine = nx.dot(ny);
                    const Complex both = integral(
                        x,
                        t,
                        _body.areas[j],
                        kDivisions,
                        [&](const Eigen::Vector3d& y) -> Complex
                        {
                            const Eigen::Vector3d d = x - y;
                            const double r2 = d.squaredNorm(), r = std::sqrt(r2), inverse = 1.0 / r;
                            const Complex G = scattering::green(_k, r);
                            const double dx = d.dot(nx) * inverse, dy = d.dot(ny) * inverse;
                            const Complex first = Complex(inverse, _k) * G;
                            const Complex second =
                                first * inverse * cosine +
                                (_k * _k - 3.0 * inverse * Complex(inverse, _k)) * G * dx * dy;
                            return first * dy + alpha * second;
                        });
                    _matrix(j, i) = std::complex<float>(-both);
                }
            }
        });
    stop.throwIfRequested();
}

GmresReport RigidBody::solve(const IncidentField& incident,
                             Eigen::VectorXcd& strength,
                             const base::StopToken& stop) const
{
    const Complex alpha(0.0, -1.0 / _k);
    base::ThreadPool pool(_threads);
    const ComplexOperator apply = [&](const Eigen::VectorXcd& x, Eigen::VectorXcd& y)
    {
        const Eigen::VectorXcf in = x.cast<std::complex<float>>();
        const Eigen::Index n = in.size();
        pool.run(
            [&](int thread)
            {
                const Eigen::Index from = n * thread / _threads, to = n * (thread + 1) / _threads;
                y.segment(from, to - from) =
                    (_matrix.middleCols(from, to - from).transpose() * in).cast<Complex>();
            });
    };
    return gmres(apply,
                 incident.pressure_Pa + alpha * incident.slope_Pa_m,
                 strength,
                 kResidual,
                 kMostIterations,
                 stop);
}

Eigen::VectorXcd RigidBody::scattered(const Eigen::Matrix3Xd& points,
                                      const Eigen::VectorXcd& strength,
                                      int threads) const
{
    const auto ofElement = [&](const Eigen::Vector3d& x, Eigen::Index j)
    {
        const Eigen::Vector3d normal = _body.normals.col(j);
        return integral(
            x,
            {_body.corners.col(3 * j), _body.corners.col(3 * j + 1), _body.corners.col(3 * j + 2)},
            _body.areas[j],
            kDivisions,
            [&](const Eigen::Vector3d& y) { return scattering::greenSlope(_k, x - y, normal); });
    };
    return scattering::atEach(points,
                              threads,
                              [&](const Eigen::Vector3d& x)
                              {
                                  Complex sum = 0.0;
                                  for (Eigen::Index j = 0; j < _body.size(); ++j)
                                      sum += strength[j] * ofElement(x, j);
                                  return sum;
                              });
}

} // namespace midair::haptics
