// Method:  edges collapse in the order of their quadric errors
// Paper:   M. Garland, P. S. Heckbert, "Surface simplification using quadric error metrics", 1997
// Differs: vertices stay vertices of the input, and none leaves
//          its pixels; shells and handles stay
// ADR:     0078, 0050

#include "recon/mesh/decimate.h"

#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

namespace floatstage::recon {
namespace {

/// Refuses the collapses that slivers.h would.
template <class Mesh>
class Guard : public OpenMesh::Decimater::ModBaseT<Mesh> {
 public:
  using Self = Guard;
  using Handle = OpenMesh::Decimater::ModHandleT<Self>;
  using Base = OpenMesh::Decimater::ModBaseT<Mesh>;
  using CollapseInfo = OpenMesh::Decimater::CollapseInfoT<Mesh>;

  explicit Guard(Mesh& mesh) : Base(mesh, true) {}
  const std::string& name() const override { return name_; }
  void set(FaceNormals normals, bool thin) {
    normals_ = normals;
    thin_ = thin;
  }

  float collapse_priority(const CollapseInfo& collapse) override {
    return may_collapse(Base::mesh(), collapse.v0v1, normals_, false, thin_) ? float(Base::LEGAL_COLLAPSE)
                                                                             : float(Base::ILLEGAL_COLLAPSE);
  }

 private:
  std::string name_ = "Guard";
  FaceNormals normals_;
  bool thin_ = false;
};

}  // namespace

void decimate(HalfEdges& mesh, FaceNormals normals, std::size_t triangles) {
  // Fans around a corner and thin limbs end in triangles that only slivers could replace: those are taken
  // when nothing better is left.
  for (const bool thin : {false, true}) {
    if (mesh.n_faces() <= triangles) return;
    OpenMesh::Decimater::DecimaterT<HalfEdges> decimater(mesh);
    OpenMesh::Decimater::ModQuadricT<HalfEdges>::Handle quadrics;
    Guard<HalfEdges>::Handle guard;
    decimater.add(quadrics);
    decimater.add(guard);
    decimater.module(quadrics).unset_max_err();
    decimater.module(guard).set(normals, thin);
    if (decimater.initialize()) decimater.decimate_to_faces(0, triangles);
    mesh.garbage_collection();
  }
}

}  // namespace floatstage::recon
