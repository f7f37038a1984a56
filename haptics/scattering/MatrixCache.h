#pragma once

#include "haptics/scattering/ClosedBody.h"

#include <Eigen/Core>

#include <filesystem>
#include <functional>
#include <string>

namespace midair::haptics
{

/// Matrices of bodies, kept in files by what they are made from. Files are no more trusted than any
/// other input: one whose size, head, checksum or numbers are wrong is told of, and not used.
struct MatrixCache
{
    std::filesystem::path folder = {}; ///< made if it isn't there; empty: nothing is kept
    double mostBytes = 4e9;            ///< > 0; of all files; those that were used last stay
    double leastMaking_s = 2.0;        ///< >= 0; what is made faster isn't kept
    std::function<void(const std::string&)> told = {}; ///< what is read, kept and wrong

    /// Returns the file for the matrix of \a body at \a wavelength_m; its name has all that the
    /// matrix depends on as a hash of 128 bits.
    std::filesystem::path fileFor(const ClosedBody& body, double wavelength_m) const;
    /// Reads \a matrix (\a n x \a n) from \a file, of fileFor(). Returns true if it could.
    bool read(const std::filesystem::path& file, Eigen::Index n, Eigen::MatrixXcf& matrix) const;
    /// Writes \a matrix to \a file, of fileFor(), under another name first, and removes the files
    /// that were not used for longest beyond mostBytes.
    void write(const std::filesystem::path& file, const Eigen::MatrixXcf& matrix) const;

private:
    void tell(const std::string& what) const;
    void prune() const;
};

} // namespace midair::haptics
