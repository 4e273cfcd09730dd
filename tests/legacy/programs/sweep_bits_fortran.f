      PROGRAM SWBITS
C     PRINTS EVERY NUMBER OF A SWEEP IN ALL ITS DIGITS
      INTEGER MF, MP, MK, MT
      PARAMETER (MF=8, MP=100, MK=20, MT=5)
      INCLUDE 'flankload.inc'
      INTEGER NK, NT, NF, N1, N2, INFO, I
      INTEGER NS1(MF), NS2(MF), KSTAT(MK*MT), NPAIR(MK), KFL(MP*MK)
      DOUBLE PRECISION A1(MK), A2(MK), TQ(MT), X1(2), X2(2)
      DOUBLE PRECISION XY1(2*MP), XY2(2*MP), C1(MP*MP), C2(MP*MP)
      DOUBLE PRECISION PHI(MK*MT), T(MK*MT), T2(MK*MT), C(3*MK*MT)
      DOUBLE PRECISION FF(MF*MK*MT), R(MP*MK), E(MP*MK)
      DOUBLE PRECISION F(MP*MK*MT), G(MP*MK*MT)
      READ (5,*) NK, NT, NF, N1, N2
      READ (5,*) (NS1(I), I = 1, NF), (NS2(I), I = 1, NF)
      READ (5,*) (A1(I), I = 1, NK), (A2(I), I = 1, NK)
      READ (5,*) (TQ(I), I = 1, NT), X1, X2
      READ (5,*) (XY1(I), I = 1, 2*N1), (C1(I), I = 1, N1*N1)
      READ (5,*) (XY2(I), I = 1, 2*N2), (C2(I), I = 1, N2*N2)
      CALL FLANKLOAD_SWEEP_POINTS (NK, NT, NF, N1, N2, 0, N1, 1, 1,
     &     A1, A2, TQ, X1, X2, NS1, XY1, C1, NS2, XY2, C2,
     &     KSTAT, PHI, T, T2, C, FF, NPAIR, KFL, R, E, F, G, INFO)
      WRITE (6,'(I8)') INFO
      WRITE (6,20) (PHI(I), I = 1, NK*NT), (T(I), I = 1, NK*NT),
     &     (T2(I), I = 1, NK*NT), (C(I), I = 1, 3*NK*NT),
     &     (FF(I), I = 1, NF*NK*NT), (R(I), I = 1, N1*NK),
     &     (E(I), I = 1, N1*NK), (F(I), I = 1, N1*NK*NT),
     &     (G(I), I = 1, N1*NK*NT)
   20 FORMAT (ES25.17E3)
      END
