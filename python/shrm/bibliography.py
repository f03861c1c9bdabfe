"""The bibliography: what is cited by key, as in ``[RH02] eq. 14``, at the line that computes it.

Rendering in frequency space, and what it is compared with

    [RH02]     R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
    [R02]      R. Ramamoorthi. A Signal-Processing Framework for Forward and Inverse Rendering. PhD thesis,
               Stanford, 2002. Chapter 5 is the long form of [RH02].
    [RH01]     R. Ramamoorthi, P. Hanrahan. An Efficient Representation for Irradiance Environment Maps.
               SIGGRAPH 2001.
    [CON99]    B. Cabral, M. Olano, P. Nemec. Reflection Space Image Based Rendering. SIGGRAPH 1999.
    [KM00]     J. Kautz, M. McCool. Approximation of Glossy Reflection with Prefiltered Environment Maps.
               Graphics Interface 2000.
    [KVHS00]   J. Kautz, P.-P. Vazquez, W. Heidrich, H.-P. Seidel. A Unified Approach to Prefiltered
               Environment Maps. EGWR 2000.
    [LK03]     J. Lehtinen, J. Kautz. Matrix Radiance Transfer. I3D 2003.
    [SKS02]    P.-P. Sloan, J. Kautz, J. Snyder. Precomputed Radiance Transfer for Real-Time Rendering in
               Dynamic, Low-Frequency Lighting Environments. SIGGRAPH 2002.
    [KSS02]    J. Kautz, P.-P. Sloan, J. Snyder. Fast, Arbitrary BRDF Shading for Low-Frequency Lighting
               Using Spherical Harmonics. EGWR 2002.
    [WAT92]    S. Westin, J. Arvo, K. Torrance. Predicting Reflectance Functions from Complex Surfaces.
               SIGGRAPH 1992.
    [SHHS03]   P.-P. Sloan, J. Hall, J. Hart, J. Snyder. Clustered Principal Components for Precomputed
               Radiance Transfer. ACM TOG 22(3), 2003.

Mathematics

    [D77]      J. Duchon. Splines Minimizing Rotation-Invariant Semi-Norms in Sobolev Spaces. Constructive
               Theory of Functions of Several Variables, 1977.
    [W04]      H. Wendland. Scattered Data Approximation. Cambridge University Press, 2004.
    [OS83]     A. van Oosterom, J. Strackee. The Solid Angle of a Plane Triangle. IEEE Transactions on
               Biomedical Engineering 30(2), 1983.
    [SC97]     P. Shirley, K. Chiu. A Low Distortion Map Between Disk and Square. Journal of Graphics Tools
               2(3), 1997.
    [D82]      M. Duffy. Quadrature Over a Pyramid or Cube of Integrands with a Singularity at a Vertex.
               SIAM Journal on Numerical Analysis 19(6), 1982.
    [HMT11]    N. Halko, P.-G. Martinsson, J. Tropp. Finding Structure with Randomness: Probabilistic
               Algorithms for Constructing Approximate Matrix Decompositions. SIAM Review 53(2), 2011.

Layouts, materials, light and color

    [HS98]     W. Heidrich, H.-P. Seidel. View-Independent Environment Maps. Graphics Hardware 1998.
    [R98]      S. Rusinkiewicz. A New Change of Variables for Efficient BRDF Representation. EGWR 1998.
    [WMLT07]   B. Walter, S. Marschner, H. Li, K. Torrance. Microfacet Models for Refraction through Rough
               Surfaces. EGSR 2007.
    [LKYU12]   J. Löw, J. Kronander, A. Ynnerman, J. Unger. BRDF Models for Accurate and Efficient
               Rendering of Glossy Surfaces. ACM TOG 31(1), 2012.
    [BSH12]    M. Bagher, C. Soler, N. Holzschuch. Accurate Fitting of Measured Reflectances Using a
               Shifted Gamma Micro-facet Distribution. Computer Graphics Forum 31(4), 2012.
    [AP07]     M. Ashikhmin, S. Premoze. Distribution-based BRDFs. Technical report, University of Utah,
               2007.
    [DJ18]     J. Dupuy, W. Jakob. An Adaptive Parameterization for Efficient Material Acquisition and
               Rendering. ACM TOG 37(6), 2018.
    [MPBM03]   W. Matusik, H. Pfister, M. Brand, L. McMillan. A Data-Driven Reflectance Model. ACM TOG
               22(3), 2003.
    [DGNK99]   K. J. Dana, B. van Ginneken, S. K. Nayar, J. J. Koenderink. Reflectance and Texture of Real-
               World Surfaces. ACM TOG 18(1), 1999.
    [KD98]     J. J. Koenderink, A. J. van Doorn. Phenomenological Description of Bidirectional Surface
               Reflection. JOSA A 15(11), 1998.
    [BBP14]    L. Belcour, P. Barla, R. Pacanowski. ALTA: A BRDF Analysis Library. Workshop on Material
               Appearance Modeling, 2014.
    [PH10]     M. Pharr, G. Humphreys. Physically Based Rendering, 2nd edition. Morgan Kaufmann, 2010.
    [LFTG97]   E. Lafortune, S.-C. Foo, K. Torrance, D. Greenberg. Non-Linear Approximation of Reflectance
               Functions. SIGGRAPH 1997.
    [B94]      D. Banks. Illumination in Diverse Codimensions. SIGGRAPH 1994.
    [AS00]     M. Ashikhmin, P. Shirley. An Anisotropic Phong BRDF Model. Journal of Graphics Tools 5(2),
               2000.
    [H14]      E. Heitz. Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs. JCGT 3(2),
               2014.
    [PSS99]    A. J. Preetham, P. Shirley, B. Smits. A Practical Analytic Model for Daylight. SIGGRAPH
               1999.
    [WSS13]    C. Wyman, P.-P. Sloan, P. Shirley. Simple Analytic Approximations to the CIE XYZ Color
               Matching Functions. JCGT 2(2), 2013.
    [CIE15]    CIE 15:2004. Colorimetry, 3rd edition. Vienna, 2004. Its tables T.1 and T.4 are also the data
               sets doi:10.25039/CIE.DS.xvudnb9b (observer) and doi:10.25039/CIE.DS.hjfjmt59 (D65).
    [SMPTE177] SMPTE RP 177. Derivation of Basic Television Color Equations, 1993.
    [Lam85]    K. M. Lam. Metamerism and Colour Constancy. PhD thesis, Bradford, 1985.
    [BT709]    ITU-R Recommendation BT.709-6, 2015.
    [KCPS13]   F. Knoeppel, K. Crane, U. Pinkall, P. Schroeder. Globally Optimal Direction Fields. ACM TOG
               32(4), 2013.
    [R04]      S. Rusinkiewicz. Estimating Curvatures and Their Derivatives on Triangle Meshes. 3DPVT
               2004.
    [MDSB02]   M. Meyer, M. Desbrun, P. Schroeder, A. Barr. Discrete Differential-Geometry Operators for
               Triangulated 2-Manifolds. VisMath 2002.
"""
