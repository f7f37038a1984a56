// Rectangles of meshes, against where the meshes were put.
#include "haptics/surface/FlatFaces.h"

#include "haptics/base/Units.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <Eigen/Geometry>

#include <cmath>
#include <initializer_list>
#include <set>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

/// A grid of quads over [0, 1] x [0, 1], each of two triangles; \a place takes them somewhere.
template<typename Place>
TriangleMesh grid(int columns, int rows, const Place& place)
{
    TriangleMesh mesh;
    mesh.vertices.resize(3, (columns + 1) * (rows + 1));
    mesh.triangles.resize(3, 2 * columns * rows);
    for (int r = 0; r <= rows; ++r)
        for (int c = 0; c <= columns; ++c)
            mesh.vertices.col(r * (columns + 1) + c) =
                place(static_cast<double>(c) / columns, static_cast<double>(r) / rows);
    int t = 0;
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c)
        {
            const int a = r * (columns + 1) + c, b = a + columns + 1;
            mesh.triangles.col(t++) << a, a + 1, b + 1;
            mesh.triangles.col(t++) << b, a, b + 1; // wound the other way round
        }
    return mesh;
}

TriangleMesh sheet(double width_m, double height_m, int columns = 1, int rows = 1)
{
    const Eigen::Isometry3d pose =
        Eigen::Translation3d(0.1, -0.2, 0.3) *
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 0.5).normalized());
    return grid(columns,
                rows,
                [=](double u, double v) -> Eigen::Vector3d
                { return pose * Eigen::Vector3d((u - 0.5) * width_m, (v - 0.5) * height_m, 0.0); });
}

/// A box around the origin whose faces are wound outwards, or inwards.
TriangleMesh box(const Eigen::Vector3d& size_m, bool outwards = true)
{
    TriangleMesh mesh;
    mesh.vertices.resize(3, 8);
    for (int i = 0; i < 8; ++i)
        mesh.vertices.col(i) << (i & 1 ? 0.5 : -0.5) * size_m.x(),
            (i & 2 ? 0.5 : -0.5) * size_m.y(), (i & 4 ? 0.5 : -0.5) * size_m.z();
    mesh.triangles.resize(3, 12);
    mesh.triangles << 0, 3, 4, 7, 0, 5, 2, 7, 0, 6, 1, 7, //
        2, 2, 5, 5, 1, 1, 6, 6, 4, 4, 3, 3,               //
        1, 1, 6, 6, 4, 4, 3, 3, 2, 2, 5, 5;
    for (Eigen::Index t = 0; t < 12; ++t)
    {
        // Outwards whatever the order above.
        const Eigen::Vector3d a = mesh.vertices.col(mesh.triangles(0, t));
        const Eigen::Vector3d b = mesh.vertices.col(mesh.triangles(1, t));
        const Eigen::Vector3d c = mesh.vertices.col(mesh.triangles(2, t));
        if (((b - a).cross(c - a).dot(a + b + c) > 0.0) != outwards)
            std::swap(mesh.triangles(1, t), mesh.triangles(2, t));
    }
    return mesh;
}

} // namespace

TEST(FlatFaces, ASheetIsItsRectangleHoweverFinelyDivided)
{
    for (const int parts : {1, 3, 40})
    {
        const FlatFaces found = flatFacesOf(sheet(0.3, 0.2, parts, parts));
        EXPECT_EQ(found.problem, "");
        ASSERT_EQ(found.faces.size(), 1u);
        const Reflector& one = found.faces[0].rectangle;
        EXPECT_FALSE(found.faces[0].isOfBody);
        EXPECT_LT((one.position - Eigen::Vector3d(0.1, -0.2, 0.3)).norm(), 1e-12);
        const Eigen::Matrix3d turn =
            Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 0.5).normalized()).toRotationMatrix();
        EXPECT_NEAR(std::abs(one.normal.dot(turn.col(2))), 1.0, 1e-12);
        const bool isLong = std::abs(one.along.dot(turn.col(0))) > 0.5;
        EXPECT_NEAR(std::abs(one.along.dot(turn.col(isLong ? 0 : 1))), 1.0, 1e-12);
        EXPECT_NEAR(one.size_m[isLong ? 0 : 1], 0.3, 1e-12);
        EXPECT_NEAR(one.size_m[isLong ? 1 : 0], 0.2, 1e-12);
        EXPECT_NEAR(one.along.dot(one.normal), 0.0, 1e-14);
    }
}

TEST(FlatFaces, ABoxHasSixThatLookOutwardsHoweverItIsWound)
{
    for (const bool outwards : {true, false})
    {
        const FlatFaces found = flatFacesOf(box({0.3, 0.2, 0.1}, outwards));
        EXPECT_EQ(found.problem, "");
        ASSERT_EQ(found.faces.size(), 6u);
        for (const FlatFace& face : found.faces)
        {
            EXPECT_TRUE(face.isOfBody);
            EXPECT_GT(face.rectangle.normal.dot(face.rectangle.position), 0.04);
        }
    }
    EXPECT_EQ(flatFacesOf(box({0.3, 0.2, 0.003})).faces.size(), 2u) << "edges reflect nothing";
}

TEST(FlatFaces, WhatIsNoRectangleIsNamed)
{
    const auto cylinder = [](double degrees, int parts)
    {
        return grid(parts,
                    1,
                    [=](double u, double v)
                    {
                        const double turn = base::toRadians(degrees) * u;
                        return Eigen::Vector3d(0.2 * std::cos(turn), 0.2 * std::sin(turn), v * 0.1);
                    });
    };
    EXPECT_EQ(flatFacesOf(cylinder(90.0, 9)).problem, "is curved");
    EXPECT_EQ(flatFacesOf(cylinder(10.0, 1000)).problem, "is curved");
    EXPECT_TRUE(flatFacesOf(cylinder(90.0, 9)).faces.empty());
    EXPECT_EQ(flatFacesOf(cylinder(90.0, 2)).problem, "") << "two sides of an octagon";

    TriangleMesh triangle = sheet(0.3, 0.2);
    triangle.triangles.conservativeResize(3, 1);
    EXPECT_EQ(flatFacesOf(triangle).problem, "has a face that is no rectangle");
    TriangleMesh notched = sheet(0.3, 0.2, 5, 5);
    notched.triangles.conservativeResize(3, notched.triangles.cols() - 2);
    EXPECT_EQ(flatFacesOf(notched).problem, "has a face that is no rectangle");
    TriangleMesh slanted = sheet(0.3, 0.2);
    slanted.vertices.col(0) += 0.02 * (slanted.vertices.col(1) - slanted.vertices.col(0));
    EXPECT_EQ(flatFacesOf(slanted).problem, "has a face that is no rectangle");

    EXPECT_NE(flatFacesOf(sheet(0.3, 0.009)).problem.find("as wide as 10 mm"), std::string::npos);
    EXPECT_EQ(flatFacesOf(TriangleMesh()).problem, "");
    EXPECT_TRUE(flatFacesOf(TriangleMesh()).faces.empty());
}

TEST(FlatFaces, ClosedMeshesAreBodies)
{
    for (const bool outwards : {true, false})
    {
        const TriangleMesh mesh = box({0.1, 0.2, 0.3}, outwards);
        const FlatFaces found = flatFacesOf(mesh);
        ASSERT_NE(found.body, nullptr);
        EXPECT_EQ(found.body->vertices, mesh.vertices);
        EXPECT_EQ(found.body->triangles, mesh.triangles);
    }
    const FlatFaces ball = flatFacesOf(*sphere(0.02, 8));
    EXPECT_EQ(ball.problem, "is curved");
    ASSERT_NE(ball.body, nullptr) << "of any form";
    EXPECT_EQ(ball.body->vertices.cols(), 2 + 7 * 16) << "its poles and its seam are joined";
    EXPECT_EQ(ball.body->triangles.cols(), 2 * 16 + 6 * 2 * 16);
    EXPECT_EQ(flatFacesOf(sheet(0.1, 0.2)).body, nullptr) << "it is open";
    EXPECT_EQ(flatFacesOf(*sphere(0.02, 52)).body, nullptr) << "10608 triangles";
    TriangleMesh torn = box({0.1, 0.2, 0.3});
    torn.triangles.conservativeResize(3, torn.triangles.cols() - 1);
    EXPECT_EQ(flatFacesOf(torn).body, nullptr);
}

TEST(FlatFaces, TooManyAreNamed)
{
    TriangleMesh mesh;
    for (int i = 0; i < 9; ++i)
    {
        const TriangleMesh one = sheet(0.3, 0.2);
        const Eigen::Index before = mesh.vertices.cols(), faces = mesh.triangles.cols();
        mesh.vertices.conservativeResize(3, before + 4);
        mesh.triangles.conservativeResize(3, faces + 2);
        mesh.vertices.rightCols(4) = one.vertices.colwise() + Eigen::Vector3d(i, 0.0, 0.0);
        mesh.triangles.rightCols(2) = one.triangles.array() + static_cast<int>(before);
    }
    EXPECT_EQ(flatFacesOf(mesh).problem, "has 9 flat faces, over 8");
}

// Whatever a file has: no crash, no NaN.
TEST(FlatFaces, BadMeshesHaveNone)
{
    TriangleMesh mesh = sheet(0.3, 0.2);
    mesh.vertices(1, 2) = std::nan("");
    EXPECT_NE(flatFacesOf(mesh).problem, "");
    mesh.vertices(1, 2) = 1e300;
    EXPECT_NE(flatFacesOf(mesh).problem, "");
    mesh = sheet(0.3, 0.2);
    mesh.triangles.setZero();
    EXPECT_TRUE(flatFacesOf(mesh).faces.empty());
    mesh = box({0.3, 0.2, 0.1});
    std::swap(mesh.triangles(1, 0), mesh.triangles(2, 0));
    EXPECT_EQ(flatFacesOf(mesh).problem, "has triangles that face inwards and outwards");
}

TEST(FlatFaces, MoveWithTheirMesh)
{
    const FlatFace face = flatFacesOf(sheet(0.3, 0.2)).faces.at(0);
    const Eigen::Isometry3d pose =
        Eigen::Translation3d(0.5, 0.0, 0.0) * Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitY());
    const FlatFace moved = face.movedBy(pose);
    EXPECT_LT((moved.rectangle.position - pose * face.rectangle.position).norm(), 1e-14);
    EXPECT_LT((moved.rectangle.normal - pose.linear() * face.rectangle.normal).norm(), 1e-14);
    EXPECT_EQ(moved.rectangle.size_m, face.rectangle.size_m);
}
